// The answer of `why-not`.
#include <fmt/format.h>

#include <algorithm>

#include "host/inspect/why/why_not.hpp"

namespace pxpl5::host::inspect {

namespace {

constexpr std::array<std::string_view, 17> verdict_names = {
    "shown",    "overwritten", "lost_depth_test", "shut_out",     "outside_edge",    "other_region",
    "left_out", "masked",      "clipped",         "back_face",    "no_pixel_center", "no_area",
    "not_sent", "not_crossed", "nothing",         "not_in_frame", "unknown"};

std::string subject_of(const WhyNotFinding& f, const TriangleVerdict& v) {
    const std::string surface = surface_text(f.shown.surfaces, v.surface);
    if (v.verdict == Verdict::not_crossed && v.name) {
        return fmt::format("Cell ({}, {}, {}) of {}", v.name->i, v.name->j, v.name->k, surface);
    }
    if (!v.name) {
        return "S" + surface.substr(1);
    }
    std::string text = to_text(*v.name);
    text[0] = 'T';
    return fmt::format("{} of {}", text, surface);
}

std::string rival_text(const WhyNotFinding& f, const TriangleVerdict& v) {
    if (!v.rival) {
        return "the background";
    }
    const std::string what = v.rival->cell ? to_text(v.rival->cell->name)
                                           : fmt::format("the primitive at {}", v.rival->address);
    return v.rival->surface == v.surface
               ? what
               : fmt::format("{} of {}", what, surface_text(f.shown.surfaces, v.rival->surface));
}

std::string cell_range(const ReplayedCell& cell, double isovalue) {
    const auto [low, high] = std::ranges::minmax(cell.values);
    return fmt::format("its eight values, {:g} to {:g}, are all {} {:g}", low, high,
                       cell.inside == 0 ? "below" : "at or above", isovalue);
}

std::string nothing_text(const TriangleVerdict& v) {
    if (v.edge < 0) {
        return "has no triangle on the pixel's ray, and none in its region";
    }
    const std::string what =
        v.facts->cell ? to_text(v.facts->cell->name) : "the primitive at " + v.facts->address;
    return fmt::format(
        "has no triangle on the pixel's ray; the nearest triangle in the region is {}, whose "
        "edge {} passes {:.2f} pixels from the center of the pixel (value {})",
        what, v.edge, v.distance_px, v.edge_value);
}

std::string regions_text(const TriangleVerdict& v) {
    std::string text;
    for (const RegionPlace& place : v.regions) {
        text += fmt::format("{}({}, {})", text.empty() ? "" : ", ", place.column, place.row);
    }
    return text;
}

std::string surfaces_text(std::size_t count) {
    return count == 0   ? "no surface"
           : count == 1 ? "surface 0 only"
                        : fmt::format("surfaces 0 to {}", count - 1);
}

/// The predicate of the sentence about a triangle or a surface.
std::string fate_of(const WhyNotFinding& f, const TriangleVerdict& v) {
    switch (v.verdict) {
        case Verdict::shown:
            return "is what the pixel shows";
        case Verdict::overwritten:
            return fmt::format("was stored at depth {}, then overwritten by {} at depth {}", v.z,
                               rival_text(f, v), v.rival_z);
        case Verdict::lost_depth_test:
            return fmt::format(
                "covers the pixel at depth {}, but lost the depth test to {} at "
                "depth {}",
                v.z, rival_text(f, v), v.rival_z);
        case Verdict::shut_out:
            return fmt::format(
                "covers the pixel at depth {}, but is transparent: its stipple mask hides this "
                "pixel",
                v.z);
        case Verdict::outside_edge:
            if (v.edge < 0) {
                return "was sent for this region, but does not cover the pixel";
            }
            return fmt::format(
                "was sent for this region, but the center of the pixel lies {:.2f} "
                "pixels outside of its edge {} (value {})",
                v.distance_px, v.edge, v.edge_value);
        case Verdict::other_region:
            return fmt::format("does not touch the pixel's region ({}, {}); it was sent for {}",
                               f.place.column, f.place.row, regions_text(v));
        case Verdict::left_out:
            return "was sent, but its Renderer refused the segment: " + v.reason;
        case Verdict::masked:
            return "is hidden by a mask";
        case Verdict::clipped:
            return "was clipped away by " + v.plane;
        case Verdict::back_face:
            return "was culled: its back faces the eye";
        case Verdict::no_pixel_center:
            return "was culled: it covers no pixel center";
        case Verdict::no_area:
            return "was culled: it has no area from this viewpoint";
        case Verdict::not_sent:
            return "was never sent: " + v.reason;
        case Verdict::not_crossed:
            return "was never sent, because the surface does not pass through the cell: " +
                   cell_range(*v.cell, *f.shown.surfaces[v.surface].isovalue);
        case Verdict::nothing:
            return nothing_text(v);
        case Verdict::not_in_frame:
            return fmt::format("is not in the frame, which shows {}",
                               surfaces_text(f.shown.surfaces.size()));
        case Verdict::unknown:
            break;
    }
    return "has no verdict, because data are missing: " + v.reason;
}

Answer answer_of(const WhyNotFinding& f, const TriangleVerdict& v) {
    Answer answer;
    answer.data("verdict", verdict_names.at(static_cast<std::size_t>(v.verdict)))
        .data("sentence", sentence_of(f, v))
        .data("surface", v.surface);
    if (v.name) {
        answer.object("triangle", answer_of(*v.name));
    }
    if (v.edge >= 0) {
        answer.data("edge", v.edge)
            .data("edge_value", v.edge_value)
            .data("distance_px", v.distance_px);
    }
    if (v.rival) {
        answer.data("z", v.z).data("rival_z", v.rival_z).data("rival_address", v.rival->address);
        if (v.rival->cell) {
            answer.object("rival", answer_of(v.rival->cell->name));
        }
    }
    if (!v.regions.empty()) {
        std::vector<double> regions;
        std::ranges::transform(v.regions, std::back_inserter(regions), &RegionPlace::number);
        answer.data("regions", regions);
    }
    answer.data_if("plane", v.plane);
    if (v.cell) {
        answer.data("values", v.cell->values);
    }
    return answer.data_if("reason", v.reason);
}

}  // namespace

std::string sentence_of(const WhyNotFinding& finding, const TriangleVerdict& verdict) {
    return fmt::format("{} {}.", subject_of(finding, verdict), fate_of(finding, verdict));
}

Answer answer_of(const WhyNotFinding& f) {
    std::vector<Answer> all;
    for (const TriangleVerdict& v : f.all) {
        all.push_back(answer_of(f, v));
        if (f.all.size() > 1) {
            all.back().line("  " + sentence_of(f, v));
        }
    }
    Answer answer = answer_of(f, f.verdict);
    answer.line(sentence_of(f, f.verdict))
        .line(sentence_of(f.shown))
        .data("frame", f.frame)
        .data("x", f.x)
        .data("y", f.y)
        .data("shows", sentence_of(f.shown));
    if (f.all.size() > 1) {
        answer.line("").line(f.expected.cell ? "all triangles of the cell" : "all surfaces");
    }
    return answer.list("all", std::move(all));
}

}  // namespace pxpl5::host::inspect
