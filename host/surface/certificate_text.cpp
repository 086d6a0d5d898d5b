#include <fmt/core.h>

#include "host/surface/certificate.hpp"

namespace pxpl5::host {

namespace {

constexpr std::size_t max_defects_in_text = 8;
constexpr double mm3_per_ml = 1000;

constexpr std::array<std::string_view, defect_kinds> kind_names = {
    "open_edge",     "overfull_edge",     "misoriented_edge",  "pinched_vertex",
    "unused_vertex", "repeated_triangle", "collapsed_triangle"};

constexpr std::array<std::string_view, defect_kinds> kind_meanings = {
    "open edges off the volume's border",
    "edges with three triangles or more",
    "edges whose two triangles run the same way",
    "vertices with more than one fan of triangles",
    "vertices of no triangle",
    "triangles that repeat another's vertices",
    "triangles with a vertex twice"};

std::string closed_words(const Certificate& c) {
    if (!c.closed_but_for_border()) {
        return fmt::format("not closed: {} {} ({} {}{})", c.holes, c.holes == 1 ? "hole" : "holes",
                           c.count(DefectKind::open_edge),
                           c.count(DefectKind::open_edge) == 1 ? "open edge" : "open edges",
                           c.has_grid ? " off the volume's border" : "");
    }
    return c.border_edges == 0
               ? "closed"
               : fmt::format("closed but for the volume's border ({} edges there)", c.border_edges);
}

double volume_ml(const Certificate& c) {
    return c.is_inside_out() ? -c.volume_mm3 / mm3_per_ml : c.volume_mm3 / mm3_per_ml;
}

std::string volume_words(const Certificate& c) {
    if (!c.closed_but_for_border()) return "not defined: the surface has holes";
    if (!c.oriented()) return "not defined: neighbors have different windings";
    return fmt::format("{:.3f} ml{}{}", volume_ml(c),
                       c.border_edges > 0 ? " (closed by the faces of the scan)" : "",
                       c.is_inside_out() ? "; the faces point inwards" : "");
}

std::string defect_text(const Defect& defect) {
    std::string text = fmt::format("{} at {:.2f} {:.2f} {:.2f} mm", name_of(defect.kind),
                                   defect.p_mm.x, defect.p_mm.y, defect.p_mm.z);
    if (defect.cell) {
        text += fmt::format(", cell {} {} {} case {}", defect.cell->i, defect.cell->j,
                            defect.cell->k, defect.cell->inside);
    }
    return text;
}

std::string defects_text(const Certificate& c) {
    std::string text;
    for (std::size_t kind = 0; kind < defect_kinds; ++kind) {
        if (c.defect_counts[kind] == 0) continue;
        const bool is_of_file = kind == 0 && !c.has_grid;
        text += fmt::format("\n  {} {}", c.defect_counts[kind],
                            is_of_file ? "open edges" : kind_meanings[kind]);
        std::size_t listed = 0;
        for (const Defect& defect : c.defects) {
            if (static_cast<std::size_t>(defect.kind) != kind) continue;
            if (listed++ == max_defects_in_text) {
                text += "\n    ...";
                break;
            }
            text += "\n    " + defect_text(defect);
        }
    }
    return text;
}

std::vector<double> list(glm::dvec3 v) {
    return {v.x, v.y, v.z};
}

Fields defect_fields(const Defect& defect) {
    Fields fields = {{"kind", std::string(name_of(defect.kind))}, {"p_mm", list(defect.p_mm)}};
    if (defect.cell) {
        fields.push_back(
            {"cell", std::vector<double>{double(defect.cell->i), double(defect.cell->j),
                                         double(defect.cell->k)}});
        fields.push_back({"case", std::int64_t{defect.cell->inside}});
    }
    return fields;
}

Fields certificate_fields(const Certificate& c, std::string_view name) {
    Fields fields = {{"surface", std::string(name)},
                     {"closed", c.closed()},
                     {"closed_but_for_border", c.closed_but_for_border()},
                     {"watertight", c.watertight()},
                     {"watertight_but_for_border", c.watertight_but_for_border()},
                     {"manifold", c.manifold()},
                     {"oriented", c.oriented()},
                     {"triangles", c.triangles},
                     {"vertices", c.vertices},
                     {"edges", c.edges},
                     {"euler", c.euler()},
                     {"components", c.components},
                     {"border_edges", c.border_edges},
                     {"open_edges", c.count(DefectKind::open_edge)},
                     {"holes", c.holes},
                     {"degenerate", c.degenerate},
                     {"slivers", c.slivers},
                     {"collapsed", c.collapsed},
                     {"area_mm2", c.area_mm2},
                     {"inside_out", c.is_inside_out()}};
    if (c.has_volume()) fields.push_back({"volume_ml", volume_ml(c)});
    if (const auto genus = c.genus()) fields.push_back({"genus", *genus});
    if (!c.bounds_mm.empty) {
        fields.push_back({"low_mm", list(c.bounds_mm.low)});
        fields.push_back({"high_mm", list(c.bounds_mm.high)});
    }
    Fields counts;
    for (std::size_t kind = 0; kind < defect_kinds; ++kind) {
        counts.push_back({std::string(kind_names[kind]), c.defect_counts[kind]});
    }
    fields.push_back({"defect_counts", std::move(counts)});
    std::vector<Fields> defects;
    for (const Defect& defect : c.defects) defects.push_back(defect_fields(defect));
    fields.push_back({"defects", std::move(defects)});
    return fields;
}

}  // namespace

std::string_view name_of(DefectKind kind) {
    return kind_names[static_cast<std::size_t>(kind)];
}

Reply certificate_reply(const Certificate& c, std::string_view name) {
    Reply reply;
    reply.fields = certificate_fields(c, name);
    if (c.triangles == 0) {
        reply.text = fmt::format("{}: no triangles", name);
        reply.warnings = {reply.text};
        return reply;
    }
    reply.text = fmt::format("{}: {}, {}, {}", name, closed_words(c),
                             c.manifold() ? "manifold" : "not manifold",
                             c.oriented() ? "oriented" : "not consistently oriented");
    if (c.is_inside_out()) reply.text += ", inside out";
    reply.text += fmt::format("\n  {} triangles, {} vertices, {} edges; Euler number {}; {} {}",
                              c.triangles, c.vertices, c.edges, c.euler(), c.components,
                              c.components == 1 ? "component" : "components");
    if (const auto genus = c.genus()) reply.text += fmt::format("; genus {}", *genus);
    reply.text +=
        fmt::format("\n  area {:.1f} mm2, enclosed volume {}", c.area_mm2, volume_words(c));
    const glm::dvec3 &low = c.bounds_mm.low, &high = c.bounds_mm.high;
    reply.text +=
        fmt::format("\n  {:.2f} .. {:.2f}, {:.2f} .. {:.2f}, {:.2f} .. {:.2f} mm{}", low.x, high.x,
                    low.y, high.y, low.z, high.z, c.has_grid ? " (LPS)" : "");
    reply.text += fmt::format("\n  {} triangles of no area, {} with an angle below {:g} degree",
                              c.degenerate, c.slivers, sliver_angle_deg);
    if (c.collapsed > 0) {
        reply.text +=
            fmt::format("\n  {} more with two corners at one place, not counted", c.collapsed);
    }
    if (const std::int64_t overfull = c.count(DefectKind::overfull_edge); overfull > 0) {
        reply.text +=
            c.watertight_but_for_border()
                ? fmt::format(
                      "\n  watertight{}: each edge has as many triangles in one direction "
                      "as in the other, also the {} with more than two",
                      c.border_edges > 0 ? " but for the volume's border" : "", overfull)
                : fmt::format(
                      "\n  not watertight: {} edges have more triangles in one direction "
                      "than in the other",
                      c.unbalanced_edges);
    }
    reply.text += defects_text(c);
    return reply;
}

}  // namespace pxpl5::host
