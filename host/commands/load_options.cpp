#include "host/commands/load_options.hpp"

#include <fmt/core.h>

#include <array>
#include <cmath>

#include "generated/vocabulary.hpp"

namespace pxpl5::host {

namespace {

constexpr int max_voxels = static_cast<int>(max_volume_voxels);

std::vector<std::string> split(std::string_view text, char separator) {
    std::vector<std::string> parts(1);
    for (const char c : text) {
        if (c == separator) {
            parts.emplace_back();
        } else {
            parts.back() += c;
        }
    }
    return parts;
}

std::vector<double> spacing(const char* key, const Arguments& arguments) {
    const glm::dvec3 mm =
        parse_triple(key, arguments.text(key, ""), min_spacing_mm, max_spacing_mm);
    return {mm.x, mm.y, mm.z};
}

std::vector<std::uint32_t> whole_triple(const char* key, const std::string& text) {
    const glm::dvec3 size = parse_triple(key, text, 1, max_voxels);
    if (size != glm::floor(size)) {
        refuse_command(fmt::format("{}: '{}' is not in whole voxels", key, text));
    }
    return {static_cast<std::uint32_t>(size.x), static_cast<std::uint32_t>(size.y),
            static_cast<std::uint32_t>(size.z)};
}

/// "10:99,0:127,5:40": first and last voxel along each axis.
void take_crop(const std::string& text, ImportOptions& options) {
    const std::vector<std::string> axes = split(text, ',');
    if (axes.size() != 3) {
        refuse_command(fmt::format("crop: '{}' is not of the form A:B,C:D,E:F", text));
    }
    for (const std::string& axis : axes) {
        const std::vector<std::string> ends = split(axis, ':');
        if (ends.size() != 2) {
            refuse_command(fmt::format("crop: '{}' is not of the form FIRST:LAST", axis));
        }
        const int first = parse_whole("crop", ends[0], 0, max_voxels - 1);
        const int last = parse_whole("crop", ends[1], first, max_voxels - 1);
        options.crop_first.push_back(static_cast<std::uint32_t>(first));
        options.crop_size.push_back(static_cast<std::uint32_t>(last - first + 1));
    }
}

/// "512x512x100,int16,be,128": size, type, byte order, bytes before the first value.
void take_raw(const std::string& text, ImportOptions& options) {
    const std::vector<std::string> parts = split(text, ',');
    if (parts.size() < 2) {
        refuse_command(fmt::format("raw: '{}' is not of the form XxYxZ,TYPE[,be][,OFFSET]", text));
    }
    const std::vector<std::uint32_t> size = whole_triple("raw", parts[0]);
    options.raw = std::make_unique<bus::schema::RawLayoutT>();
    options.raw->nx = size[0];
    options.raw->ny = size[1];
    options.raw->nz = size[2];
    options.raw->type = parts[1];
    for (std::size_t i = 2; i < parts.size(); ++i) {
        if (parts[i] == "be" || parts[i] == "le") {
            options.raw->big_endian = parts[i] == "be";
        } else {
            constexpr double most = 1e15;
            options.raw->offset =
                static_cast<std::uint64_t>(parse_number("raw: offset", parts[i], 0, most));
        }
    }
}

}  // namespace

std::vector<Parameter> load_option_list() {
    return {
        {"series", "N", "number of the series in a DICOM folder; 'info' lists the series"},
        whole_value("frame", "N", 1, max_frames, "volume of a time series, from 1"),
        {"crop", "A:B,C:D,E:F", "first and last voxel to keep along x, y and z"},
        {"resample", "XxYxZ", "new number of voxels"},
        {"resample_mm", "X,Y,Z", "new spacing in millimeters"},
        number_value("smooth", "MM", 0, max_smooth_mm, "standard deviation of a Gauss filter",
                     "mm"),
        {"spacing", "X,Y,Z", "spacing in millimeters, for a file that does not state it"},
        {"orientation", "ABC",
         "sides to which x, y and z point, for example RAI, for a file that does not state them"},
        {"origin", "X,Y,Z", "place of the first voxel in millimeters, LPS, for such a file"},
        {"raw", "XxYxZ,TYPE[,be][,OFFSET]", "layout of a file without a header"},
        choice_value("gradient", enum_names<GradientKernel>,
                     "gradient kernel; central: central differences, as in the paper; smooth: "
                     "means over 3x3x3 voxels, so that noise shows less. It changes the shading "
                     "alone, while smooth= changes the voxels",
                     enum_names<GradientKernel>[0]),
        choice_value("read", enum_names<ReadBy>,
                     "reader of the values of uncompressed files: the host, which sends them, or "
                     "the GPs, which all must see the files; automatic: the GPs above 8 GiB",
                     enum_names<ReadBy>[0]),
    };
}

ImportOptions load_options(const Arguments& arguments) {
    ImportOptions options;
    options.series = arguments.text("series", "");
    options.frame = static_cast<std::uint32_t>(arguments.number("frame", 0));
    if (arguments.has("spacing")) {
        options.spacing_mm = spacing("spacing", arguments);
    }
    options.orientation = arguments.text("orientation", "");
    if (arguments.has("origin")) {
        constexpr double most = double{max_scene_mm};
        const glm::dvec3 mm = parse_triple("origin", arguments.text("origin", ""), -most, most);
        options.origin_mm = {mm.x, mm.y, mm.z};
    }
    if (arguments.has("raw")) {
        take_raw(arguments.text("raw", ""), options);
    }
    if (arguments.has("crop")) {
        take_crop(arguments.text("crop", ""), options);
    }
    if (arguments.has("resample") && arguments.has("resample_mm")) {
        refuse_command("resample= and resample_mm= exclude each other");
    }
    if (arguments.has("resample")) {
        options.resample_size = whole_triple("resample", arguments.text("resample", ""));
    }
    if (arguments.has("resample_mm")) {
        options.resample_spacing_mm = spacing("resample_mm", arguments);
    }
    options.smooth_mm = arguments.number("smooth", 0);
    options.gradient =
        enum_named<GradientKernel>(arguments.text("gradient", enum_names<GradientKernel>[0].data()))
            .value();
    options.read = enum_named<ReadBy>(arguments.text("read", enum_names<ReadBy>[0].data())).value();
    return options;
}

}  // namespace pxpl5::host
