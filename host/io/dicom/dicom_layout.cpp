// How the pixels of a DICOM file lie in their bits.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "host/io/dicom/dicom_elements.hpp"

namespace pxpl5::host::io {

namespace {

constexpr std::array readable_bits = {8, 16, 32};

/// The value of a US element, or `otherwise` if the element is absent or empty.
int stated_or(const gdcm::DataSet& data, std::uint16_t element, int otherwise) {
    const gdcm::Tag tag(0x0028, element);
    return bytes_of(data, tag).empty() ? otherwise : unsigned_of(data, tag);
}

}  // namespace

void read_pixel_layout(const std::string& file, const gdcm::DataSet& data, DicomSlice& slice) {
    slice.photometric = text_of(data, gdcm::Tag(0x0028, 0x0004));
    slice.samples = stated_or(data, 0x0002, 1);
    if (slice.samples == 0) {
        throw ImportError(fmt::format(
            "{}: samples per pixel (0028,0002) are 0, must be 1. The file is damaged", file));
    }
    slice.bits = stated_or(data, 0x0100, 0);
    if (std::ranges::find(readable_bits, slice.bits) == readable_bits.end()) {
        throw ImportError(fmt::format("{}: bits allocated (0028,0100) are {}, must be 8, 16 or 32",
                                      file, slice.bits));
    }
    slice.bits_stored = stated_or(data, 0x0101, slice.bits);
    if (slice.bits_stored < 1 || slice.bits_stored > slice.bits) {
        throw ImportError(
            fmt::format("{}: bits stored (0028,0101) are {}, must be 1 to the {} bits allocated "
                        "(0028,0100)",
                        file, slice.bits_stored, slice.bits));
    }
    const int high_bit = stated_or(data, 0x0102, slice.bits_stored - 1);
    if (slice.bits_stored < slice.bits && high_bit != slice.bits_stored - 1) {
        throw ImportError(
            fmt::format("{}: high bit (0028,0102) is {}, must be {}, because bits stored "
                        "(0028,0101) are {}: values that do not begin at bit 0 are not read",
                        file, high_bit, slice.bits_stored - 1, slice.bits_stored));
    }
    const int representation = stated_or(data, 0x0103, 0);
    if (representation != 0 && representation != 1) {
        throw ImportError(
            fmt::format("{}: pixel representation (0028,0103) is {}, must be 0 (unsigned) or 1 "
                        "(signed)",
                        file, representation));
    }
    slice.is_signed = representation == 1;
}

}  // namespace pxpl5::host::io
