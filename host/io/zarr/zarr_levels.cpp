#include "host/io/zarr/zarr_levels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "host/io/values/component.hpp"
#include "host/io/values/header_text.hpp"
#include "host/io/values/import_request.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::size_t max_levels = 64;

/// The names of the axes if the image does not state them: of fewer axes the last ones.
constexpr std::array<const char*, 5> usual_axes = {"t", "c", "z", "y", "x"};

double unit_of(const ZarrImage& image, const Json& axis, bool is_time) {
    constexpr std::array<std::pair<const char*, double>, 9> lengths = {{
        {"angstrom", 1e-7},
        {"nanometer", 1e-6},
        {"micrometer", 1e-3},
        {"millimeter", 1},
        {"centimeter", 10},
        {"decimeter", 100},
        {"meter", 1e3},
        {"inch", 25.4},
        {"foot", 304.8},
    }};
    constexpr std::array<std::pair<const char*, double>, 5> times = {{
        {"microsecond", 1e-3},
        {"millisecond", 1},
        {"second", 1e3},
        {"minute", 6e4},
        {"hour", 3.6e6},
    }};
    const Json unit = axis.value("unit", Json());
    if (unit.is_null()) {
        return 0;
    }
    if (is_time) {
        const auto found =
            std::ranges::find_if(times, [&](const auto& each) { return unit == each.first; });
        return found == times.end() ? 0 : found->second;
    }
    const auto found =
        std::ranges::find_if(lengths, [&](const auto& each) { return unit == each.first; });
    if (found == lengths.end()) {
        throw ImportError(
            fmt::format("{}: the unit of axis {} is {}, must be a length, as "
                        "micrometer or millimeter",
                        image.file(), shown(axis.value("name", Json()).dump()),
                        shown(unit.dump().substr(0, 40))));
    }
    return found->second;
}

/// The axes of arrays with so many of them. The last are y and x, before them z.
std::vector<ZarrAxis> axes_of(const ZarrImage& image, std::size_t count) {
    std::vector<ZarrAxis> axes;
    const Json stated = image.scales.value("axes", Json());
    if (!stated.is_null() && !stated.is_array()) {
        throw ImportError(fmt::format("{}: axes is {}, must be a list", image.file(),
                                      shown(stated.dump().substr(0, 100))));
    }
    for (const Json& axis : stated.is_array() ? stated : Json::array()) {
        const Json name = axis.is_object() ? axis.value("name", Json()) : axis;
        axes.push_back({name.is_string() ? name.get<std::string>() : ""});
        if (axis.is_object() && axes.back().name != "c") {
            axes.back().unit = unit_of(image, axis, axes.back().name == "t");
        }
    }
    if (axes.empty()) {
        const auto first = usual_axes.end() - static_cast<std::ptrdiff_t>(count);
        for (auto name = first; name != usual_axes.end(); ++name) {
            axes.push_back({*name});
        }
    }
    std::string names;
    for (const ZarrAxis& axis : axes) {
        names += axis.name.size() == 1 ? axis.name : "?";
    }
    constexpr std::array<std::string_view, 8> known = {"yx",   "zyx",  "cyx",  "tyx",
                                                       "czyx", "tzyx", "tcyx", "tczyx"};
    if (axes.size() != count || std::ranges::count(known, names) == 0) {
        throw ImportError(
            fmt::format("{}: its axes are {}, and its arrays have {}; the axes must be t, c, z, y, "
                        "x in this order, and t, c and z may be missing",
                        image.file(), shown(stated.dump().substr(0, 100)), count));
    }
    return axes;
}

/// Applies the transformations of a list, each a scale or a translation of each axis.
void apply(const ZarrImage& image, const Json& list, ZarrLevel& level) {
    if (!list.is_null() && !list.is_array()) {
        throw ImportError(fmt::format("{}: coordinateTransformations is {}, must be a list",
                                      image.file(), shown(list.dump().substr(0, 100))));
    }
    for (const Json& each : list.is_array() ? list : Json::array()) {
        const Json kind = each.is_object() ? each.value("type", Json()) : Json();
        if (kind == "identity") {
            continue;
        }
        const Json values = kind.is_string() ? each.value(kind.get<std::string>(), Json()) : Json();
        const bool is_right =
            (kind == "scale" || kind == "translation") && values.is_array() &&
            values.size() == level.scale.size() &&
            std::ranges::all_of(values, [](const Json& value) { return value.is_number(); });
        if (!is_right) {
            throw ImportError(fmt::format(
                "{}: a transformation is {}, must be a scale or a translation of {} axes",
                image.file(), shown(each.dump().substr(0, 100)), level.scale.size()));
        }
        level.has_scale = level.has_scale || kind == "scale";
        for (std::size_t axis = 0; axis < values.size(); ++axis) {
            const double value = values[axis].get<double>();
            if (kind == "scale") {
                level.scale[axis] *= value;
                level.shift[axis] *= value;
            } else {
                level.shift[axis] += value;
            }
        }
    }
}

/// The folder of a level. Throws ImportError if the image names a place outside.
fs::path folder_of_level(const ZarrImage& image, const Json& data_set) {
    const Json name = data_set.is_object() ? data_set.value("path", Json()) : Json();
    const fs::path below = name.is_string() ? fs::path(name.get<std::string>()) : fs::path();
    const bool is_inside =
        !below.empty() && below.is_relative() && std::ranges::count(below, fs::path("..")) == 0;
    if (!is_inside) {
        throw ImportError(fmt::format("{}: the path of a level is {}, must be a folder inside",
                                      image.file(), shown(name.dump().substr(0, 100))));
    }
    return image.root / below;
}

ZarrLevel read_level(const ZarrImage& image, const Json& data_set, const AllowedFolders& allowed) {
    ZarrLevel level;
    level.array =
        read_zarr_array(folder_of_level(image, data_set), image.root / ".zattrs", allowed);
    level.scale.assign(level.array.shape.size(), 1);
    level.shift.assign(level.array.shape.size(), 0);
    level.axes = axes_of(image, level.array.shape.size());
    apply(image, data_set.value("coordinateTransformations", Json()), level);
    apply(image, image.scales.value("coordinateTransformations", Json()), level);
    return level;
}

bool fits(const std::array<std::uint64_t, 3>& sizes, Component component) {
    std::uint64_t bytes = component_bytes(component);
    for (const std::uint64_t size : sizes) {
        if (size > max_volume_voxels) {
            return false;
        }
        bytes *= size;
    }
    return bytes <= max_volume_bytes;
}

}  // namespace

std::array<std::uint64_t, 3> ZarrLevel::sizes() const {
    std::array<std::uint64_t, 3> sizes = {1, 1, 1};
    for (std::size_t axis = 0; axis < axes.size(); ++axis) {
        const std::size_t at = std::string_view("xyz").find(axes[axis].name);
        if (at != std::string_view::npos) {
            sizes[at] = array.shape[axis];
        }
    }
    return sizes;
}

std::optional<ZarrImage> zarr_image_at(const fs::path& folder) {
    std::error_code failure;
    if (!fs::is_regular_file(folder / ".zattrs", failure)) {
        return std::nullopt;
    }
    const Json attributes = read_json(folder / ".zattrs", folder / ".zgroup", {});
    const Json scales = attributes.value("multiscales", Json());
    if (!scales.is_array() || scales.empty() || !scales[0].is_object()) {
        return std::nullopt;
    }
    return ZarrImage{folder, scales[0]};
}

ZarrLevel zarr_level_for(const ZarrImage& image, const fs::path& path,
                         const AllowedFolders& allowed) {
    const Json sets = image.scales.value("datasets", Json());
    if (!sets.is_array() || sets.empty() || sets.size() > max_levels) {
        throw ImportError(fmt::format("{}: names {} datasets, must name 1 to {}", image.file(),
                                      sets.is_array() ? sets.size() : 0, max_levels));
    }
    const fs::path wanted = fs::absolute(path).lexically_normal() / "";
    const bool is_root = wanted == image.root / "";
    std::string last;
    for (const Json& set : sets) {
        const fs::path folder = (folder_of_level(image, set) / "").lexically_normal();
        if (!is_root && wanted != folder) {
            continue;
        }
        ZarrLevel level = read_level(image, set, allowed);
        level.number = static_cast<std::size_t>(&set - &sets[0]) + 1;
        level.count = sets.size();
        const auto sizes = level.sizes();
        if (!is_root || fits(sizes, level.array.component)) {
            return level;
        }
        last = fmt::format("{}x{}x{}", sizes[0], sizes[1], sizes[2]);
    }
    throw ImportError(
        is_root ? fmt::format("{}: its coarsest level has {} voxels, must be at most {} along an "
                              "axis and {} bytes in all",
                              image.root.string(), last, max_volume_voxels, max_volume_bytes)
                : fmt::format("{}: is none of the {} levels that {} names", path.string(),
                              sets.size(), image.file()));
}

}  // namespace pxpl5::host::io
