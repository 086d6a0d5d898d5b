// What `why-not` says: for people and for programs.
#include <fmt/format.h>

#include <algorithm>

#include "host/inspect/why/why_fields.hpp"
#include "host/inspect/why/why_not.hpp"

namespace pxpl5::host::inspect {

namespace {

constexpr std::array<std::string_view, 17> verdict_names = {
    "shown",    "overwritten", "lost_depth_test", "shut_out",     "outside_edge",    "other_region",
    "left_out", "masked",      "clipped",         "back_face",    "no_pixel_centre", "no_area",
    "not_sent", "not_crossed", "nothing",         "not_in_frame", "unknown"};

std::string name_of(Verdict verdict) {
    return std::string(verdict_names.at(static_cast<std::size_t>(verdict)));
}

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

std::string cell_range(const CellAgain& cell, double isovalue) {
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
        "has no triangle on the pixel's ray; the nearest in the region is {}, whose "
        "edge {} passes {:.2f} pixels from the pixel's centre (value {})",
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

/// What became of it, behind its name.
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
                "covers the pixel at depth {}, but is transparent: this pixel is one of those that "
                "show what is behind it",
                v.z);
        case Verdict::outside_edge:
            return fmt::format(
                "was sent for this region, but the pixel's centre lies {:.2f} "
                "pixels outside of its edge {} (value {})",
                v.distance_px, v.edge, v.edge_value);
        case Verdict::other_region:
            return fmt::format("does not touch the pixel's region ({}, {}); it was sent for {}",
                               f.place.column, f.place.row, regions_text(v));
        case Verdict::left_out:
            return "was sent, but its Renderer left the segment out: " + v.reason;
        case Verdict::masked:
            return "is hidden by a mask";
        case Verdict::clipped:
            return "was clipped away by " + v.plane;
        case Verdict::back_face:
            return "was culled: it turns its back to the eye";
        case Verdict::no_pixel_centre:
            return "was culled: it covers no pixel's centre";
        case Verdict::no_area:
            return "was culled: seen from here it has no area";
        case Verdict::not_sent:
            return "was never sent: " + v.reason;
        case Verdict::not_crossed:
            return "was never sent, as the surface does not pass through it: " +
                   cell_range(*v.cell, *f.shown.surfaces[v.surface].isovalue);
        case Verdict::nothing:
            return nothing_text(v);
        case Verdict::not_in_frame:
            return fmt::format("is not in the frame, which shows {}",
                               surfaces_text(f.shown.surfaces.size()));
        case Verdict::unknown:
            break;
    }
    return "gets no verdict, as data are missing: " + v.reason;
}

Fields verdict_fields(const WhyNotFinding& f, const TriangleVerdict& v) {
    const auto number = [](auto value) { return static_cast<std::int64_t>(value); };
    Fields fields{{"verdict", name_of(v.verdict)},
                  {"sentence", sentence_of(f, v)},
                  {"surface", number(v.surface)}};
    if (v.name) {
        fields.push_back({"triangle", triangle_fields(*v.name)});
    }
    if (v.edge >= 0) {
        fields.push_back({"edge", number(v.edge)});
        fields.push_back({"edge_value", number(v.edge_value)});
        fields.push_back({"distance_px", v.distance_px});
    }
    if (v.rival) {
        fields.push_back({"z", number(v.z)});
        fields.push_back({"rival_z", number(v.rival_z)});
        fields.push_back({"rival_address", v.rival->address});
        if (v.rival->cell) {
            fields.push_back({"rival", triangle_fields(v.rival->cell->name)});
        }
    }
    if (!v.regions.empty()) {
        std::vector<double> regions;
        std::ranges::transform(v.regions, std::back_inserter(regions),
                               [](const RegionPlace& p) { return static_cast<double>(p.number); });
        fields.push_back({"regions", regions});
    }
    if (!v.plane.empty()) {
        fields.push_back({"plane", v.plane});
    }
    if (v.cell) {
        fields.push_back(
            {"values", std::vector<double>(v.cell->values.begin(), v.cell->values.end())});
    }
    if (!v.reason.empty()) {
        fields.push_back({"reason", v.reason});
    }
    return fields;
}

}  // namespace

std::string sentence_of(const WhyNotFinding& finding, const TriangleVerdict& verdict) {
    return fmt::format("{} {}.", subject_of(finding, verdict), fate_of(finding, verdict));
}

Reply why_not_reply(const WhyNotFinding& f) {
    Reply reply;
    reply.text = sentence_of(f, f.verdict) + "\n" + sentence_of(f.shown);
    if (f.all.size() > 1) {
        reply.text += f.expected.cell ? "\n\nall triangles of the cell" : "\n\nall surfaces";
    }
    std::vector<Fields> all;
    for (const TriangleVerdict& v : f.all) {
        if (f.all.size() > 1) {
            reply.text += "\n  " + sentence_of(f, v);
        }
        all.push_back(verdict_fields(f, v));
    }
    reply.fields = verdict_fields(f, f.verdict);
    reply.fields.push_back({"frame", static_cast<std::int64_t>(f.frame)});
    reply.fields.push_back({"x", std::int64_t{f.x}});
    reply.fields.push_back({"y", std::int64_t{f.y}});
    reply.fields.push_back({"shows", sentence_of(f.shown)});
    reply.fields.push_back({"all", all});
    return reply;
}

}  // namespace pxpl5::host::inspect
