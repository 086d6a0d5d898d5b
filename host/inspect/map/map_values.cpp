#include "host/inspect/map/map_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>

#include "host/base/error.hpp"

namespace pxpl5::host::inspect {

namespace {

constexpr MapInfo kinds[] = {
    {MapKind::idle, "idle", MapScale::count, false, "Idle",
     "instructions run while the pixel is disabled"},
    {MapKind::busy, "busy", MapScale::count, false, "Busy",
     "instructions run while the pixel is enabled"},
    {MapKind::covered, "covered", MapScale::count, false, "Covered",
     "primitives that hold the pixel"},
    {MapKind::overdraw, "overdraw", MapScale::count, false, "Overdraw",
     "primitives that wrote the pixel"},
    {MapKind::cost, "cost", MapScale::count, true, "Cost", "cycles of the region at 40 MHz"},
    {MapKind::gp, "gp", MapScale::category, false, "Drawn by", "gp"},
    {MapKind::renderer, "renderer", MapScale::category, true, "Region of", "renderer"},
    {MapKind::cell_case, "case", MapScale::category, false, "Marching cubes, 15 classes", "case"},
    {MapKind::slab, "slab", MapScale::count, false, "Slab", "number of the visible slab"},
    {MapKind::depth, "depth", MapScale::count, false, "Depth", "z, 0 is near"},
    {MapKind::normal, "normal", MapScale::direction, false, "Normal", "eye space"},
};

/// Values of a region for a map.
struct RegionView {
    const RecordedRegion& region;
    const RegionCensus& census;
    std::vector<Primitive> primitives;

    const Primitive* visible(std::size_t pixel) const {
        const std::uint32_t number = census.visible[pixel];
        return number == no_primitive ? nullptr : &primitives[number];
    }
    const renderer::Segment* segment(std::size_t pixel) const {
        const Primitive* primitive = visible(pixel);
        return primitive == nullptr ? nullptr : &region.plan.parts[primitive->part].segment;
    }
};

std::int64_t case_of(const RegionView& view, std::size_t pixel) {
    const Primitive* primitive = view.visible(pixel);
    if (primitive == nullptr) {
        return no_value;
    }
    if (!primitive->origin) {
        throw RequestError(ExitCode::bad_data,
                           primitive->is_of_scene
                               ? "the frame shows an archive, which has no voxel cells and no cases"
                           : primitive->is_of_slice
                               ? "the frame shows a slice of the volume, which has no voxel cells "
                                 "and no cases; hide it: planes off"
                           : primitive->detail > 0
                               ? "the frame is simplified, so that triangles have no voxel cells "
                                 "and no cases; draw it exactly"
                               : "the provenance of triangles was not recorded; record with "
                                 "--record full or flight");
    }
    return case_class(primitive->origin->inside());
}

std::int64_t value_of(MapKind kind, const RegionView& view, std::size_t pixel) {
    const RegionCensus& census = view.census;
    const bool drawn = census.surface[pixel] != 0;
    switch (kind) {
        case MapKind::idle:
            return static_cast<std::int64_t>(census.counts.instructions) - census.active[pixel];
        case MapKind::busy:
            return census.active[pixel];
        case MapKind::covered:
            return census.covered[pixel];
        case MapKind::overdraw:
            return census.written[pixel];
        case MapKind::cost:
            return static_cast<std::int64_t>(census.counts.cycles);
        case MapKind::gp:
            return view.segment(pixel) != nullptr ? view.segment(pixel)->gp : no_value;
        case MapKind::renderer:
            return view.region.renderer;
        case MapKind::cell_case:
            return case_of(view, pixel);
        case MapKind::slab:
            return view.segment(pixel) != nullptr ? view.segment(pixel)->slab : no_value;
        case MapKind::depth:
            return drawn ? census.z[pixel] : no_value;
        case MapKind::normal:
            return drawn ? census.normal[pixel] : no_value;
    }
    return no_value;
}

void place_region(MapValues& map, const RecordedFrame& frame, const RegionView& view) {
    const RegionPlace& place = view.region.place;
    const int height = static_cast<int>(frame.draw().height());
    const int rows = std::min(region_px, (place.view + 1) * height - place.y0_px);
    const int columns = std::min(region_px, map.width - place.x0_px);
    for (int y = 0; y < rows; ++y) {
        for (int x = 0; x < columns; ++x) {
            const auto from = static_cast<std::size_t>(y * region_px + x);
            const auto to =
                static_cast<std::size_t>((place.y0_px + y) * map.width + place.x0_px + x);
            map.values[to] = value_of(map.kind, view, from);
            // A frame of several whose mean the picture is may have no colors yet.
            map.picture[to] = view.census.rgb.empty() ? 0 : view.census.rgb[from];
        }
    }
}

constexpr int corners = 8;

/// The set after corner c has gone to place[c].
std::uint8_t moved(std::uint8_t set, const std::array<int, corners>& place) {
    unsigned result = 0;
    for (unsigned c = 0; c < corners; ++c) {
        result |= (set >> c & 1U) << static_cast<unsigned>(place[c]);
    }
    return static_cast<std::uint8_t>(result);
}

/// Where corners go in a quarter turn: about z, x to y; about x, y to z.
constexpr std::array<int, corners> turn_about_z = {1, 3, 0, 2, 5, 7, 4, 6};
constexpr std::array<int, corners> turn_about_x = {2, 3, 6, 7, 0, 1, 4, 5};

/// Class by set, grown from one set of each class by turns and by swapping inside and outside.
std::array<std::uint8_t, 256> make_classes() {
    // The figure's cases: none, corner, edge, ends of a face's and of the cell's diagonal, three of
    // a face, edge and far corner, three apart, face, corner and its neighbors, two far edges,
    // two chains of four that mirror each other (11 and 14), three of a face and a fourth apart,
    // four apart.
    constexpr std::array<std::uint8_t, 15> first = {0x00, 0x01, 0x03, 0x09, 0x81, 0x07, 0x83, 0x16,
                                                    0x0F, 0x17, 0xC3, 0x27, 0x87, 0x69, 0x1B};
    constexpr std::uint8_t open = 0xFF;
    std::array<std::uint8_t, 256> classes;
    classes.fill(open);
    for (std::uint8_t number = 0; number < first.size(); ++number) {
        std::vector<std::uint8_t> found{first[number]};
        while (!found.empty()) {
            const std::uint8_t set = found.back();
            found.pop_back();
            if (classes[set] == open) {
                classes[set] = number;
                found.push_back(static_cast<std::uint8_t>(~set));
                found.push_back(moved(set, turn_about_z));
                found.push_back(moved(set, turn_about_x));
            }
        }
    }
    return classes;
}

/// The signed number in ten bits of a normal.
int component(std::int64_t normal, unsigned k) {
    const int field = static_cast<int>(normal >> (10 * k) & 0x3FF);
    return field < 512 ? field : field - 1024;
}

}  // namespace

std::span<const MapInfo> map_kinds() {
    return kinds;
}

const MapInfo& info(MapKind kind) {
    return *std::ranges::find(kinds, kind, &MapInfo::kind);
}

MapKind map_kind_of(std::string_view name) {
    std::string names;
    for (const MapInfo& one : kinds) {
        if (one.name == name) {
            return one.kind;
        }
        names += fmt::format("{}{}", names.empty() ? "" : ", ", one.name);
    }
    throw RequestError(ExitCode::usage,
                       fmt::format("no map is named '{}'; the maps are {}", name, names));
}

MapValues map_values(const RecordedFrame& frame, MapKind kind,
                     const std::map<std::uint32_t, RegionCensus>& census) {
    MapValues map;
    map.kind = kind;
    map.width = static_cast<int>(frame.draw().width());
    map.height = static_cast<int>(frame.draw().height() * frame.draw().views()->size());
    const auto pixels = static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height);
    map.values.assign(pixels, no_value);
    map.picture.assign(pixels, 0);
    for (const auto& [number, region] : frame.regions) {
        place_region(map, frame,
                     RegionView{region, census.at(number), primitives_of(frame, region)});
    }
    return map;
}

MapValues map_values(const RecordedFrame& frame, MapKind kind) {
    std::map<std::uint32_t, RegionCensus> census;
    for (const auto& [number, region] : frame.regions) {
        census.emplace(number, take_census(region, primitives_of(frame, region)));
    }
    return map_values(frame, kind, census);
}

std::string to_csv(const MapValues& map) {
    std::string text;
    for (std::size_t i = 0; i < map.values.size(); ++i) {
        const std::int64_t value = map.values[i];
        if (value != no_value && map.kind == MapKind::normal) {
            fmt::format_to(std::back_inserter(text), "{}:{}:{}", component(value, 0),
                           component(value, 1), component(value, 2));
        } else if (value != no_value) {
            fmt::format_to(std::back_inserter(text), "{}", value);
        }
        text += (i + 1) % static_cast<std::size_t>(map.width) == 0 ? '\n' : ',';
    }
    return text;
}

int case_class(std::uint8_t inside) {
    static const std::array<std::uint8_t, 256> classes = make_classes();
    return classes[inside];
}

}  // namespace pxpl5::host::inspect
