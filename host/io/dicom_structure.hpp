// Whether a DICOM file is built of whole elements: where it is not, GDCM asserts, or reserves as
// much memory as a broken length asks for.
#pragma once

#include <filesystem>

namespace pxpl5::host::io {

/// Walks through all elements, sequences and fragments of `path`, which begins as a DICOM file.
/// Values are not looked at, but for the transfer syntax; the length of uncompressed pixels is left
/// to who knows how many there are. Deflated files are looked at up to where they are deflated.
///
/// Throws   ImportError naming the element, where it is, and its length beside what is left.
void check_dicom_structure(const std::filesystem::path& path);

}  // namespace pxpl5::host::io
