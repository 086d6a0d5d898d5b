// Takes the place of the GDCM sources in a build without PXPL5_DICOM.
#include <array>
#include <string_view>

#include "host/io/dicom/dicom_attributes.hpp"
#include "host/io/dicom/dicom_file.hpp"

namespace pxpl5::host::io {

struct DicomPixels::File {};

DicomPixels::DicomPixels() = default;
DicomPixels::~DicomPixels() = default;

bool begins_as_dicom(const DicomInput& input) {
    constexpr std::size_t preamble_bytes = 128;
    std::array<char, 4> mark{};
    const std::unique_ptr<std::istream> file = input.open();
    file->seekg(preamble_bytes).read(mark.data(), mark.size());
    return *file && std::string_view(mark.data(), mark.size()) == "DICM";
}

std::vector<DicomSlice> read_dicom_slices(const DicomInput& input) {
    if (begins_as_dicom(input)) {
        throw ImportError(input.path.string() +
                          ": this program was built without DICOM; build it with -DPXPL5_DICOM=ON");
    }
    return {};
}

// There are no slices without read_dicom_slices().
void DicomPixels::add(const DicomSlice& /*slice*/, ValueSink& /*sink*/) {}

DicomAttributes read_attributes(const DicomInput& /*input*/) {
    return {};
}

std::string DicomAttributes::value(std::uint16_t /*group*/, std::uint16_t /*element*/) const {
    return "";
}

}  // namespace pxpl5::host::io
