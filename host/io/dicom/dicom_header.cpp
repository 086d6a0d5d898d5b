// Reads the headers of DICOM slices.
#include "host/io/dicom/dicom_attributes.hpp"
#include "host/io/dicom/dicom_elements.hpp"
#include "host/io/dicom/dicom_file.hpp"
#include "host/io/dicom/dicom_frame_groups.hpp"
#include "host/io/dicom/dicom_structure.hpp"

#include <fmt/format.h>
#include <gdcmReader.h>
#include <gdcmTrace.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>

#include "host/io/values/file_at_work.hpp"
#include "host/io/values/file_facts.hpp"
#include "host/io/values/header_text.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

const gdcm::Tag pixels_tag(0x7fe0, 0x0010);
constexpr double max_skew_cosine = 1e-2;  // Rows and columns of an image are at right angles.

/// (0028,0030): distance of rows, then of columns. Detectors' spacing serves where no other is.
void read_spacing(const std::string& file, const gdcm::DataSet& data, const FrameGroups& groups,
                  DicomSlice& slice) {
    std::vector<double> spacing =
        groups.numbers(file, gdcm::Tag(0x0028, 0x9110), gdcm::Tag(0x0028, 0x0030));
    if (spacing.empty()) {
        spacing = numbers_of(file, data, gdcm::Tag(0x0018, 0x1164));
    }
    if (spacing.empty()) {
        slice.spacing_stated = false;
        return;
    }
    if (spacing.size() < 2 || !(spacing[0] > 0) || !(spacing[1] > 0) ||
        !std::isfinite(spacing[0]) || !std::isfinite(spacing[1])) {
        throw ImportError(
            fmt::format("{}: pixel spacing (0028,0030) is {}, must be two lengths above 0", file,
                        fmt::join(spacing, " and ")));
    }
    slice.x_step_mm *= spacing[1];
    slice.y_step_mm *= spacing[0];
}

void read_position(const std::string& file, const FrameGroups& groups, DicomSlice& slice) {
    const std::vector<double> axes =
        groups.numbers(file, gdcm::Tag(0x0020, 0x9116), gdcm::Tag(0x0020, 0x0037));
    const std::vector<double> origin =
        groups.numbers(file, gdcm::Tag(0x0020, 0x9113), gdcm::Tag(0x0020, 0x0032));
    // A file's own position is that of its first frame only.
    slice.position_stated = axes.size() == 6 && origin.size() == 3 &&
                            (slice.frames == 1 || groups.has(gdcm::Tag(0x0020, 0x9113)));
    if (axes.size() == 6) {
        const glm::dvec3 x(axes[0], axes[1], axes[2]), y(axes[3], axes[4], axes[5]);
        const double cosine = glm::dot(x, y) / (glm::length(x) * glm::length(y));
        if (!(std::abs(cosine) < max_skew_cosine)) {
            throw ImportError(fmt::format(
                "{}: the rows and columns of (0020,0037) meet at a cosine of {}, must be 0", file,
                cosine));
        }
        slice.x_step_mm = glm::normalize(x);
        slice.y_step_mm = glm::normalize(y);
    }
    if (origin.size() == 3) {
        slice.origin_mm = {origin[0], origin[1], origin[2]};
        if (!std::isfinite(origin[0] + origin[1] + origin[2])) {
            throw ImportError(fmt::format("{}: its position (0020,0032) is {}, must be finite",
                                          file, fmt::join(origin, ", ")));
        }
    }
}

double first_or(const std::vector<double>& values, double otherwise) {
    return values.empty() ? otherwise : values[0];
}

void read_scale(const std::string& file, const gdcm::DataSet& data, const FrameGroups& groups,
                DicomSlice& slice) {
    const gdcm::Tag macro(0x0028, 0x9145);
    slice.scale.slope = first_or(groups.numbers(file, macro, gdcm::Tag(0x0028, 0x1053)), 1);
    slice.scale.intercept = first_or(groups.numbers(file, macro, gdcm::Tag(0x0028, 0x1052)), 0);
    const std::vector<double> dose = numbers_of(file, data, gdcm::Tag(0x3004, 0x000e));
    slice.scale.slope *= first_or(dose, 1);
    if (!std::isfinite(slice.scale.slope) || !std::isfinite(slice.scale.intercept) ||
        slice.scale.slope == 0) {
        throw ImportError(fmt::format(
            "{}: rescale slope (0028,1053) is {} and intercept (0028,1052) {}: must be finite, the "
            "slope not 0",
            file, slice.scale.slope, slice.scale.intercept));
    }
}

/// Windows (0028,1050), (0028,1051) and their names (0028,1055). A wrong window is left out, as it
/// only changes how values look.
void read_windows(const std::string& file, const FrameGroups& groups, const std::string& charset,
                  DicomSlice& slice) {
    const gdcm::Tag macro(0x0028, 0x9132);
    std::vector<double> levels, widths;
    try {
        levels = groups.numbers(file, macro, gdcm::Tag(0x0028, 0x1050));
        widths = groups.numbers(file, macro, gdcm::Tag(0x0028, 0x1051));
    } catch (const ImportError&) {
        return;
    }
    const std::string names = utf8_of(groups.text(macro, gdcm::Tag(0x0028, 0x1055)), charset);
    std::size_t begin = 0;
    for (std::size_t k = 0; k < std::min(levels.size(), widths.size()); ++k) {
        const std::size_t end = std::min(names.find('\\', begin), names.size());
        const std::string name = trimmed(std::string_view(names).substr(begin, end - begin));
        begin = std::min(end + 1, names.size());
        const bool is_window = std::abs(levels[k]) <= most_window && widths[k] >= least_window &&
                               widths[k] <= most_window;
        const bool is_there = std::ranges::any_of(slice.windows, [&](const NamedWindow& other) {
            return other.width == widths[k] && other.level == levels[k];
        });
        if (is_window && !is_there && slice.windows.size() < max_windows) {
            slice.windows.push_back({name.substr(0, max_value_chars), widths[k], levels[k]});
        }
    }
}

/// Signed distance of frames that have no positions of their own.
std::optional<double> frame_step(const std::string& file, const gdcm::DataSet& data) {
    const std::vector<double> spacing = numbers_of(file, data, gdcm::Tag(0x0018, 0x0088));
    if (!spacing.empty() && std::isfinite(spacing[0]) && spacing[0] != 0) {
        return spacing[0];
    }
    return std::nullopt;
}

/// Frames of a dose lie at offsets from the file's position, along its normal (3004,000c).
void place_by_offsets(const std::string& file, const gdcm::DataSet& data,
                      std::vector<DicomSlice>& slices) {
    const std::vector<double> offsets = numbers_of(file, data, gdcm::Tag(0x3004, 0x000c));
    const bool has_place = data.FindDataElement(gdcm::Tag(0x0020, 0x0032)) &&
                           data.FindDataElement(gdcm::Tag(0x0020, 0x0037));
    // The standard's other way counts from the isocenter, which the file does not state.
    if (offsets.size() != slices.size() || offsets.empty() || offsets[0] != 0 || !has_place) {
        return;
    }
    for (std::size_t i = 0; i < slices.size(); ++i) {
        DicomSlice& slice = slices[i];
        slice.origin_mm +=
            offsets[i] * glm::normalize(glm::cross(slice.x_step_mm, slice.y_step_mm));
        slice.position_stated = std::isfinite(offsets[i]);
    }
}

bool is_lossy(const gdcm::Reader& reader, const gdcm::DataSet& data) {
    if (text_of(data, gdcm::Tag(0x0028, 0x2110)) == "01") {
        return true;
    }
    using gdcm::TransferSyntax;
    const TransferSyntax::TSType syntax = reader.GetFile().GetHeader().GetDataSetTransferSyntax();
    return syntax == TransferSyntax::JPEGBaselineProcess1 ||
           syntax == TransferSyntax::JPEGExtendedProcess2_4 ||
           syntax == TransferSyntax::JPEGExtendedProcess3_5 ||
           syntax == TransferSyntax::JPEGSpectralSelectionProcess6_8 ||
           syntax == TransferSyntax::JPEGFullProgressionProcess10_12 ||
           syntax == TransferSyntax::JPEGLSNearLossless;
}

/// Whether values lie in the file as in memory.
bool is_little_endian(const gdcm::Reader& reader) {
    using gdcm::TransferSyntax;
    const TransferSyntax::TSType syntax = reader.GetFile().GetHeader().GetDataSetTransferSyntax();
    return syntax == TransferSyntax::ImplicitVRLittleEndian ||
           syntax == TransferSyntax::ExplicitVRLittleEndian;
}

/// Values that all frames of a file share.
DicomSlice read_shared(const DicomInput& input, const gdcm::Reader& reader) {
    const std::string file = input.path.string();
    const gdcm::DataSet& data = reader.GetFile().GetDataSet();
    DicomSlice slice;
    slice.path = input.path;
    slice.unpacked = input.bytes;
    slice.series = text_of(data, gdcm::Tag(0x0020, 0x000e));
    slice.instance = text_of(data, gdcm::Tag(0x0008, 0x0018));
    slice.description = text_of(data, gdcm::Tag(0x0008, 0x103e));
    slice.modality = text_of(data, gdcm::Tag(0x0008, 0x0060));
    const auto whole = [&](gdcm::Tag tag) {
        const double value = first_or(numbers_of(file, data, tag), 0);
        return std::abs(value) < 1e9 ? static_cast<int>(value) : 0;
    };
    slice.series_number = whole(gdcm::Tag(0x0020, 0x0011));
    slice.instance_number = whole(gdcm::Tag(0x0020, 0x0013));
    slice.rows = unsigned_of(data, gdcm::Tag(0x0028, 0x0010));
    slice.columns = unsigned_of(data, gdcm::Tag(0x0028, 0x0011));
    const double frames = first_or(numbers_of(file, data, gdcm::Tag(0x0028, 0x0008)), 1);
    if (!(frames >= 1) || frames > static_cast<double>(max_slices)) {
        throw ImportError(fmt::format("{}: number of frames (0028,0008) is {}, must be 1 to {}",
                                      file, frames, max_slices));
    }
    slice.frames = static_cast<int>(frames);
    slice.is_lossy = is_lossy(reader, data);
    if (slice.modality == "PT") {
        slice.uptake = read_uptake(data);
    }
    slice.frame_step_mm = frame_step(file, data);
    using gdcm::TransferSyntax;
    // Positions in a deflated file are not those in its text.
    if (reader.GetFile().GetHeader().GetDataSetTransferSyntax() !=
        TransferSyntax::DeflatedExplicitVRLittleEndian) {
        slice.pixel_offset_bytes = reader.GetStreamCurrentPosition();
    }
    return slice;
}

/// The file must have the bytes that its pixels need; compressed ones, a fragment for each frame.
void check_size(const std::string& file, const gdcm::Reader& reader, const DicomSlice& slice) {
    constexpr std::uint64_t fragment_bytes = 8;
    if (slice.pixel_offset_bytes == 0) {
        return;
    }
    const std::uint64_t size = slice.input().size_bytes();
    const std::uint64_t has = size - std::min(size, slice.pixel_offset_bytes);
    const bool compressed =
        reader.GetFile().GetHeader().GetDataSetTransferSyntax().IsEncapsulated();
    const std::uint64_t pixels = static_cast<std::uint64_t>(slice.columns) *
                                 static_cast<std::uint64_t>(slice.rows) *
                                 static_cast<std::uint64_t>(slice.frames * slice.samples);
    const auto bytes = static_cast<std::uint64_t>((slice.bits + 7) / 8);
    const std::uint64_t needed = compressed
                                     ? fragment_bytes * static_cast<std::uint64_t>(slice.frames)
                                     : pixels * static_cast<std::uint64_t>(slice.bits) / 8;
    if (has < needed) {
        throw ImportError(fmt::format(
            "{}: pixel data (7fe0,0010) have {} bytes, {}x{}x{} of {} bytes need {}{}", file, has,
            slice.columns, slice.rows, slice.frames, bytes, needed, compressed ? " or more" : ""));
    }
}

void check_shape(const std::string& file, const DicomSlice& slice) {
    for (const auto& [size, name] : {std::pair{slice.columns, "columns (0028,0011)"},
                                     std::pair{slice.rows, "rows (0028,0010)"}}) {
        if (size < min_volume_voxels || size > max_volume_voxels) {
            throw ImportError(fmt::format("{}: has {} {}, must be {} to {}", file, size, name,
                                          min_volume_voxels, max_volume_voxels));
        }
    }
}

}  // namespace

bool begins_as_dicom(const DicomInput& input) {
    constexpr std::size_t preamble_bytes = 132, element_bytes = 8;
    std::array<char, preamble_bytes + element_bytes> head{};
    const std::unique_ptr<std::istream> stream = input.open();
    stream->read(head.data(), head.size());
    return *stream && std::string_view(head.data(), head.size()).substr(128, 4) == "DICM";
}

std::vector<DicomSlice> read_dicom_slices(const DicomInput& input) {
    const std::string file = input.path.string();
    if (!begins_as_dicom(input)) {
        return {};
    }
    const FileFacts facts = input.facts();
    const PixelBytes pixels = check_dicom_structure(input);
    const FileAtWork at_work(file);
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
    const std::unique_ptr<std::istream> stream = input.open();
    gdcm::Reader reader;
    reader.SetStream(*stream);
    if (!reader.ReadUpToTag(pixels_tag, {pixels_tag})) {  // Values are passed over.
        return {};
    }
    const gdcm::DataSet& data = reader.GetFile().GetDataSet();
    refuse_other_kinds(file, data);
    DicomSlice shared = read_shared(input, reader);
    if (!data.FindDataElement(gdcm::Tag(0x0028, 0x0010)) &&
        !data.FindDataElement(gdcm::Tag(0x0028, 0x0011))) {
        return {};
    }
    check_shape(file, shared);
    read_pixel_layout(file, data, shared);
    check_size(file, reader, shared);
    if (pixels.stated > pixels.left + 1) {  // Some writers forget the byte that makes it even.
        throw ImportError(fmt::format("{}: pixel data (7fe0,0010) state {} bytes, {} are left",
                                      file, pixels.stated, pixels.left));
    }
    const std::uint64_t pixel_bytes =
        static_cast<std::uint64_t>(shared.columns) * static_cast<std::uint64_t>(shared.rows) *
        static_cast<std::uint64_t>(shared.frames) * static_cast<std::uint64_t>(shared.bits) / 8;
    shared.facts = facts;
    if (pixels.stated >= pixel_bytes && is_little_endian(reader)) {
        shared.raw_offset_bytes = pixels.offset_bytes;
    }
    std::vector<DicomSlice> slices;
    for (int frame = 0; frame < shared.frames; ++frame) {
        DicomSlice slice = shared;
        const FrameGroups groups(data, frame);
        slice.frame = frame;
        read_position(file, groups, slice);
        read_spacing(file, data, groups, slice);
        read_scale(file, data, groups, slice);
        read_windows(file, groups, text_of(data, gdcm::Tag(0x0008, 0x0005)), slice);
        slice.times = read_times(data, groups);
        const auto thickness =
            groups.numbers(file, gdcm::Tag(0x0028, 0x9110), gdcm::Tag(0x0018, 0x0050));
        if (!thickness.empty() && thickness[0] > 0) {
            slice.thickness_mm = thickness[0];
        }
        slices.push_back(std::move(slice));
    }
    place_by_offsets(file, data, slices);
    refuse_time_series(file, data, slices);
    unfold_mosaic(file, data, slices);
    return slices;
}

}  // namespace pxpl5::host::io
