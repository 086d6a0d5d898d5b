// Whether a DICOM file is built of whole elements, and the elements of the image are of their
// types: where they are not, GDCM asserts, or reserves as much memory as a broken length asks for.
#pragma once

#include <cstdint>

#include "host/io/dicom/dicom_input.hpp"

namespace pxpl5::host::io {

/// Uncompressed pixels as (7fe0,0010) states them, and as the file has them.
struct PixelBytes {
    std::uint64_t stated = 0, left = 0;
    std::uint64_t offset_bytes = 0;  ///< Before them in the file.
};

/// Walks through all elements, sequences and fragments of `input`, which begins as a DICOM file.
/// Values are not looked at, but for the transfer syntax; the length of uncompressed pixels is left
/// to who knows how many there are. Deflated files are looked at up to where they are deflated.
///
/// Returns  zeros if there are no such pixels, or they are deflated.
/// Throws   ImportError naming the element, where it is, and its length beside what is left.
PixelBytes check_dicom_structure(const DicomInput& input);

}  // namespace pxpl5::host::io
