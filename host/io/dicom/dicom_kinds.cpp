// DICOM files whose pixels are no volume of gray values.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <span>

#include "host/io/dicom/dicom_elements.hpp"

namespace pxpl5::host::io {

namespace {

/// Elements that the frame increment pointer (0028,0009) of a series over time names.
struct TimeElement {
    gdcm::Tag tag;
    const char* name;
};
const std::array time_elements = {
    TimeElement{gdcm::Tag(0x0018, 0x1063), "Frame Time (0018,1063)"},
    TimeElement{gdcm::Tag(0x0018, 0x1065), "Frame Time Vector (0018,1065)"},
    TimeElement{gdcm::Tag(0x0054, 0x0030), "Phase Vector (0054,0030)"},
    TimeElement{gdcm::Tag(0x0054, 0x0060), "R-R Interval Vector (0054,0060)"},
    TimeElement{gdcm::Tag(0x0054, 0x0070), "Time Slot Vector (0054,0070)"},
    TimeElement{gdcm::Tag(0x0054, 0x0100), "Time Slice Vector (0054,0100)"}};

/// Elements that only a series over time has. They count without a frame increment pointer.
const std::array cine_elements = {
    time_elements[0], TimeElement{gdcm::Tag(0x0018, 0x0040), "Cine Rate (0018,0040)"},
    TimeElement{gdcm::Tag(0x0008, 0x2144), "Recommended Display Frame Rate (0008,2144)"}};

/// The tags of a frame increment pointer.
std::vector<gdcm::Tag> increments(const gdcm::DataSet& data) {
    const std::string bytes = bytes_of(data, gdcm::Tag(0x0028, 0x0009));
    std::vector<gdcm::Tag> tags;
    for (std::size_t at = 0; at + 4 <= bytes.size(); at += 4) {
        std::array<std::uint16_t, 2> words{};
        std::memcpy(words.data(), bytes.data() + at, sizeof words);
        tags.emplace_back(words[0], words[1]);
    }
    return tags;
}

}  // namespace

void refuse_other_kinds(const std::string& file, const gdcm::DataSet& data) {
    if (data.FindDataElement(gdcm::Tag(0x0004, 0x1220))) {
        throw NoSlices(fmt::format("{}: is a DICOMDIR, a list of files: load its folder {}", file,
                                   std::filesystem::path(file).parent_path().string()));
    }
    if (text_of(data, gdcm::Tag(0x0008, 0x0060)) == "SEG") {
        throw NoSlices(
            file +
            ": is a segmentation (SEG), whose pixels are labels: load the images it was made from");
    }
    for (const std::uint16_t element : {std::uint16_t{8}, std::uint16_t{9}}) {
        if (data.FindDataElement(gdcm::Tag(0x7fe0, element))) {
            throw NoSlices(
                fmt::format("{}: holds float pixels (7fe0,{:04x}), as parametric maps do, which "
                            "are not read: convert it to NIfTI",
                            file, element));
        }
    }
}

void refuse_time_series(const std::string& file, const gdcm::DataSet& data,
                        const std::vector<DicomSlice>& slices) {
    const bool placed = std::all_of(slices.begin(), slices.end(),
                                    [](const DicomSlice& slice) { return slice.position_stated; });
    if (slices.size() < 2 || placed) {
        return;
    }
    const std::vector<gdcm::Tag> tags = increments(data);
    const std::span<const TimeElement> elements =
        tags.empty() ? std::span<const TimeElement>(cine_elements) : time_elements;
    for (const TimeElement& element : elements) {
        if (tags.empty() ? data.FindDataElement(element.tag)
                         : std::find(tags.begin(), tags.end(), element.tag) != tags.end()) {
            throw NoSlices(fmt::format(
                "{}: its {} frames are a time series, since {} tells them apart: they are no "
                "slices, and frames without positions are not read as a time series",
                file, slices.size(), element.name));
        }
    }
}

}  // namespace pxpl5::host::io
