#include "host/inspect/why/why_not.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/base/error.hpp"
#include "host/inspect/listing/instruction_values.hpp"
#include "isa/contract/triangle_shape.hpp"

namespace pxpl5::host::inspect {

namespace {

using Kind = PartKind;

bool is_from(const Primitive& p, const RecordedRegion& region, const TriangleName& name) {
    const renderer::Segment& s = region.plan.parts[p.part].segment;
    return p.origin && s.surface == name.surface && s.slab == static_cast<std::uint32_t>(name.k) &&
           p.origin->i() == name.i && p.origin->j() == name.j &&
           p.origin->triangle() == name.triangle && p.origin->inside() != 0;
}

/// The regions of the pixel's view in which the triangle was emitted.
std::vector<RegionPlace> regions_with(const PixelInquiry& inquiry, const TriangleName& name) {
    std::vector<RegionPlace> places;
    for (const auto& [number, region] : inquiry.frame.regions) {
        if (region.place.view != inquiry.place.view) {
            continue;
        }
        const bool here = std::ranges::any_of(
            primitives_of(inquiry.frame, region),
            [&, &in = region](const Primitive& p) { return is_from(p, in, name); });
        if (here) {
            places.push_back(region.place);
        }
    }
    return places;
}

TriangleVerdict unknown(const TriangleName& name, std::string reason) {
    TriangleVerdict verdict;
    verdict.surface = name.surface;
    verdict.name = name;
    verdict.reason = std::move(reason);
    return verdict;
}

/// A primitive of the pixel's region that covers the pixel.
TriangleVerdict verdict_of_visit(PixelInquiry& inquiry, std::size_t v) {
    const std::vector<PixelVisit>& visits = inquiry.history.visits;
    const PixelVisit& visit = visits[v];
    TriangleVerdict verdict;
    verdict.facts = inquiry.facts_of(inquiry.history.primitives[visit.primitive]);
    verdict.z = visit.z.value_or(visit.after.z);
    const auto stored = [](const PixelVisit& other) { return !other.writes.empty(); };
    auto rival = visits.end();
    if (inquiry.history.is_shut_out(visit)) {
        verdict.verdict = Verdict::shut_out;
    } else if (visit.writes.empty()) {
        verdict.verdict = Verdict::lost_depth_test;
        const auto before =
            std::find_if(visits.rbegin() + static_cast<std::ptrdiff_t>(visits.size() - v),
                         visits.rend(), stored);
        rival = before == visits.rend() ? visits.end() : std::prev(before.base());
    } else {
        rival =
            std::find_if(visits.begin() + static_cast<std::ptrdiff_t>(v) + 1, visits.end(), stored);
        verdict.verdict = rival == visits.end() ? Verdict::shown : Verdict::overwritten;
    }
    if (rival != visits.end()) {
        verdict.rival = inquiry.facts_of(inquiry.history.primitives[rival->primitive]);
        verdict.rival_z = rival->after.z;
    }
    return verdict;
}

TriangleVerdict verdict_here(PixelInquiry& inquiry, const Primitive& primitive) {
    const std::vector<PixelVisit>& visits = inquiry.history.visits;
    const auto visit = std::ranges::find(visits, primitive.number, &PixelVisit::primitive);
    TriangleVerdict verdict =
        visit == visits.end()
            ? farthest_edge(inquiry, primitive)
            : verdict_of_visit(inquiry, static_cast<std::size_t>(visit - visits.begin()));
    if (!verdict.facts) {
        verdict.facts = inquiry.facts_of(primitive);
    }
    return verdict;
}

/// A segment of the pixel's region that its Renderer would not run.
std::optional<TriangleVerdict> left_out(const PixelInquiry& inquiry, const TriangleName& name) {
    for (const renderer::SegmentFault& fault : inquiry.region().plan.faults) {
        if (fault.surface == name.surface && fault.slab == static_cast<std::uint32_t>(name.k)) {
            TriangleVerdict verdict = unknown(name, fault.reason);
            verdict.verdict = Verdict::left_out;
            return verdict;
        }
    }
    return std::nullopt;
}

/// Why the streams cannot tell where triangles are, if so.
std::string streams_missing(const PixelInquiry& inquiry, std::uint32_t surface) {
    for (const auto& [number, region] : inquiry.frame.regions) {
        for (const Primitive& p : primitives_of(inquiry.frame, region)) {
            if (region.plan.parts[p.part].segment.surface != surface) {
                continue;
            }
            if (p.is_of_scene) {
                return fmt::format("surface {} belongs to an archive, which has no voxel cells",
                                   surface);
            }
            if (p.is_of_slice) {
                return fmt::format("surface {} is a slice of the volume, which has no voxel cells",
                                   surface);
            }
            if (p.detail > 0) {
                return fmt::format(
                    "surface {} is simplified in this frame (detail {}), so that "
                    "its triangles have no voxel cells; draw it exactly",
                    surface, p.detail);
            }
            if (!p.origin) {
                return fmt::format("{} was recorded without the provenance of its primitives",
                                   to_text(region.plan, p.address()));
            }
        }
    }
    return {};
}

TriangleVerdict verdict_of_triangle(PixelInquiry& inquiry, const TriangleName& name) {
    if (const auto refused = left_out(inquiry, name)) {
        return *refused;
    }
    std::optional<TriangleVerdict> best;
    for (const Primitive& p : inquiry.history.primitives) {
        if (is_from(p, inquiry.region(), name)) {
            TriangleVerdict verdict = verdict_here(inquiry, p);
            if (!best || verdict.verdict < best->verdict) {
                best = std::move(verdict);
            }
        }
    }
    if (!best) {
        std::vector<RegionPlace> places = regions_with(inquiry, name);
        if (!places.empty()) {
            best.emplace();
            best->verdict = Verdict::other_region;
            best->regions = std::move(places);
        } else if (!inquiry.frame.missing.empty()) {
            return unknown(name, inquiry.frame.missing.front());
        }
    }
    if (!best || best->verdict >= Verdict::outside_edge) {
        if (auto staged = verdict_of_stages(inquiry, name, best.has_value())) {
            return *staged;
        }
    }
    best->surface = name.surface;
    best->name = name;
    return *best;
}

/// True if the primitive has the three edges of a triangle at the places where GPs put them.
bool is_triangle(renderer::Words words) {
    return words.size() >= isa::triangle::word_count &&
           std::ranges::all_of(isa::triangle::at_edge, [&](std::size_t at) {
               const std::optional<isa::Instruction> in = isa::decode(words[at]);
               return in && in->op == isa::Op::tree_ge_zero;
           });
}

void check_cell(const PixelInquiry& inquiry, const std::array<int, 3>& cell) {
    if (!inquiry.volume.has_shape()) {
        return;
    }
    const gp::VolumeShape& shape = inquiry.volume.shape();
    const std::array<int, 3> count = {shape.nx - 1, shape.ny - 1, shape.nz - 1};
    for (std::size_t n = 0; n < 3; ++n) {
        if (cell[n] < 0 || cell[n] >= count[n]) {
            throw RequestError(
                ExitCode::usage,
                fmt::format("cell ({}, {}, {}) is outside of the volume, which has "
                            "{} x {} x {} cells, counted from 0",
                            cell[0], cell[1], cell[2], count[0], count[1], count[2]));
        }
    }
}

std::vector<TriangleVerdict> verdicts_of_cell(PixelInquiry& inquiry, const Expectation& expected) {
    const auto& cell = *expected.cell;
    check_cell(inquiry, cell);
    TriangleName name{expected.surface.value_or(0), cell[0], cell[1], cell[2],
                      expected.triangle.value_or(0)};
    const std::string missing = streams_missing(inquiry, name.surface);
    if (!missing.empty()) {
        return {unknown(name, missing)};
    }
    const CellCount count = triangles_of_cell(inquiry, name);
    if (expected.triangle) {
        if (!count.verdict && (name.triangle < 0 || name.triangle >= count.triangles)) {
            throw RequestError(
                ExitCode::usage,
                fmt::format("cell ({}, {}, {}) has {} triangles of surface {}, "
                            "counted from 0; there is no triangle {}",
                            name.i, name.j, name.k, count.triangles, name.surface, name.triangle));
        }
        return {count.verdict && count.verdict->verdict == Verdict::not_crossed
                    ? *count.verdict
                    : verdict_of_triangle(inquiry, name)};
    }
    if (count.verdict) {
        return {*count.verdict};
    }
    std::vector<TriangleVerdict> all;
    for (name.triangle = 0; name.triangle < count.triangles; ++name.triangle) {
        all.push_back(verdict_of_triangle(inquiry, name));
    }
    return all;
}

/// From the pixel's history, if a triangle of the surface is in it.
TriangleVerdict verdict_on_surface(PixelInquiry& inquiry, std::uint32_t surface) {
    std::optional<TriangleVerdict> best;
    for (std::size_t v = 0; v < inquiry.history.visits.size(); ++v) {
        const Primitive& p = inquiry.history.primitives[inquiry.history.visits[v].primitive];
        if (inquiry.region().plan.parts[p.part].segment.surface != surface) {
            continue;
        }
        TriangleVerdict verdict = verdict_of_visit(inquiry, v);
        if (!best || verdict.verdict < best->verdict ||
            (verdict.verdict == best->verdict && verdict.z < best->z)) {
            best = std::move(verdict);
        }
    }
    if (!best) {
        return verdict_of_surface(inquiry, surface);
    }
    best->surface = surface;
    best->name = best->facts->cell ? std::optional(best->facts->cell->name) : std::nullopt;
    return *best;
}

TriangleVerdict not_in_frame(std::uint32_t surface) {
    TriangleVerdict verdict;
    verdict.verdict = Verdict::not_in_frame;
    verdict.surface = surface;
    return verdict;
}

}  // namespace

TriangleVerdict farthest_edge(const PixelInquiry& inquiry, const Primitive& primitive) {
    const renderer::Words words =
        inquiry.region().plan.parts[primitive.part].segment.words.subspan(primitive.first_word);
    TriangleVerdict verdict;
    verdict.verdict = Verdict::outside_edge;
    if (!is_triangle(words)) {
        return verdict;
    }
    for (std::size_t k = 0; k < isa::triangle::at_edge.size(); ++k) {
        const isa::Coefficients c = coefficients_behind(words, isa::triangle::at_edge[k]);
        const std::int64_t value =
            form_of(c, {inquiry.history.x_in_region(), inquiry.history.y_in_region()});
        const double distance = static_cast<double>(-value) / std::hypot(c[0], c[1]);
        if (value < 0 && (verdict.edge < 0 || distance > verdict.distance_px)) {
            verdict.edge = static_cast<int>(k);
            verdict.edge_value = value;
            verdict.distance_px = distance;
        }
    }
    return verdict;
}

WhyNotFinding why_not(FrameInquiry& frame, int x, int y, const Expectation& expected) {
    PixelInquiry inquiry(frame, x, y);
    WhyNotFinding finding{inquiry.frame.number, x, y, inquiry.place, expected, {}, {}, {}};
    const auto surface_count = static_cast<std::uint32_t>(inquiry.surfaces.size());
    if (expected.surface.value_or(0) >= surface_count) {
        finding.all = {not_in_frame(expected.surface.value_or(0))};
    } else if (expected.cell) {
        finding.all = verdicts_of_cell(inquiry, expected);
    } else if (expected.surface) {
        finding.all = {verdict_on_surface(inquiry, *expected.surface)};
    } else {
        for (std::uint32_t s = 0; s < surface_count; ++s) {
            finding.all.push_back(verdict_on_surface(inquiry, s));
        }
    }
    finding.verdict = *std::ranges::min_element(finding.all, {}, &TriangleVerdict::verdict);
    // One that is not known could be nearer to being seen than what is known.
    const auto missing =
        std::ranges::find(finding.all, Verdict::unknown, &TriangleVerdict::verdict);
    if (missing != finding.all.end() && finding.verdict.verdict != Verdict::shown) {
        finding.verdict = *missing;
    }
    finding.shown = why_of(inquiry);
    return finding;
}

std::array<int, 3> parse_cell(const std::string& text) {
    std::array<int, 3> cell{};
    int used = 0;
    if (std::sscanf(text.c_str(), "%d,%d,%d%n", &cell[0], &cell[1], &cell[2], &used) != 3 ||
        static_cast<std::size_t>(used) != text.size()) {
        throw RequestError(ExitCode::usage,
                           fmt::format("--cell '{}' is not of the form i,j,k", text));
    }
    return cell;
}

}  // namespace pxpl5::host::inspect
