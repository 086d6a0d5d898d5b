// Takes the place of the GDCM sources in a build without PXPL5_DICOM.
#include <array>
#include <fstream>
#include <string_view>

#include "host/io/dicom/dicom_attributes.hpp"
#include "host/io/dicom/dicom_file.hpp"

namespace pxpl5::host::io {

struct DicomPixels::File {};

DicomPixels::DicomPixels() = default;
DicomPixels::~DicomPixels() = default;

bool begins_as_dicom(const std::filesystem::path& path) {
    constexpr std::size_t preamble_bytes = 128;
    std::array<char, 4> mark{};
    std::ifstream file(path, std::ios::binary);
    file.seekg(preamble_bytes).read(mark.data(), mark.size());
    return file && std::string_view(mark.data(), mark.size()) == "DICM";
}

std::vector<DicomSlice> read_dicom_slices(const std::filesystem::path& path) {
    if (begins_as_dicom(path)) {
        throw ImportError(path.string() +
                          ": this program was built without DICOM; build it with -DPXPL5_DICOM=ON");
    }
    return {};
}

// There are no slices without read_dicom_slices().
void DicomPixels::add(const DicomSlice& /*slice*/, ValueSink& /*sink*/) {}

DicomAttributes read_attributes(const std::filesystem::path& /*path*/) {
    return {};
}

std::string DicomAttributes::value(std::uint16_t /*group*/, std::uint16_t /*element*/) const {
    return "";
}

}  // namespace pxpl5::host::io
