// The answer of `why`: from the pixel to its instructions, its triangle and its voxels.
#include <fmt/format.h>

#include <algorithm>

#include "host/inspect/record/recorded_results.hpp"
#include "host/inspect/why/why.hpp"

namespace pxpl5::host::inspect {

namespace {

std::string point_text(const glm::dvec3& p) {
    return fmt::format("({:.3f}, {:.3f}, {:.3f})", p.x, p.y, p.z);
}

std::vector<double> point(const glm::dvec3& p) {
    return {p.x, p.y, p.z};
}

std::string triple_text(const std::array<int, 3>& v) {
    return fmt::format("({}, {}, {})", v[0], v[1], v[2]);
}

/// "left 12.3, posterior 4.0, superior 102.5 mm": LPS in words.
std::string patient_text(const glm::dvec3& mm) {
    return fmt::format("{} {:.2f} mm, {} {:.2f} mm, {} {:.2f} mm", mm.x < 0 ? "right" : "left",
                       std::abs(mm.x), mm.y < 0 ? "anterior" : "posterior", std::abs(mm.y),
                       mm.z < 0 ? "inferior" : "superior", std::abs(mm.z));
}

std::string bits_text(std::uint8_t bits, const char* none) {
    std::string text;
    for (int bit = 0; bit < 8; ++bit) {
        if ((bits >> bit & 1) != 0) {
            text += fmt::format("{}{}", text.empty() ? "" : " ", bit);
        }
    }
    return text.empty() ? none : text;
}

Answer answer_of(const CornerFacts& corner) {
    Answer answer;
    if (corner.is_center) {
        answer.line("    the center of the cell's crossings at voxel " +
                    point_text(corner.p_voxel));
    } else {
        answer
            .line(fmt::format("    {:.4f} of the way from {} = {:g} to {} = {:g}", corner.fraction,
                              triple_text(corner.voxel_0), corner.value_0,
                              triple_text(corner.voxel_1), corner.value_1))
            .data("voxel_0", corner.voxel_0)
            .data("voxel_1", corner.voxel_1)
            .data("value_0", corner.value_0)
            .data("value_1", corner.value_1)
            .data("fraction", corner.fraction);
    }
    return answer.data("voxel", point(corner.p_voxel)).data("mm", point(corner.p_mm));
}

/// The eight values in four rows; * marks values inside.
void add_values(const CellFacts& cell, Answer& answer) {
    const TriangleName& n = cell.name;
    answer.line(fmt::format("  {:>18}{:>12}{:>12}", "", fmt::format("i = {}", n.i),
                            fmt::format("i = {}", n.i + 1)));
    for (int row = 0; row < 4; ++row) {
        std::string line =
            fmt::format("  {:<18}", fmt::format("slice {}, j = {}", n.k + row / 2, n.j + row % 2));
        for (const int c : {2 * row, 2 * row + 1}) {
            line += fmt::format("{:>11g}{}", cell.values[static_cast<std::size_t>(c)],
                                (cell.origin.inside >> c & 1) != 0 ? '*' : ' ');
        }
        answer.line(line);
    }
    answer.data("values", cell.values);
}

Answer answer_of(const CellFacts& cell, const std::string& values_from) {
    const TriangleName& n = cell.name;
    Answer answer = answer_of(n);
    answer
        .line(fmt::format("cell {}: case {} (inside corners: {}), joined faces: {}",
                          triple_text({n.i, n.j, n.k}), cell.origin.inside,
                          bits_text(cell.origin.inside, "none"),
                          bits_text(cell.origin.joined, "none")))
        .data("case", cell.origin.inside)
        .data("joined_faces", cell.origin.joined)
        .data("piece", cell.origin.piece);
    if (!cell.unknown.empty()) {
        return answer.line("  the voxels are not known: " + cell.unknown)
            .data("unknown", cell.unknown);
    }
    answer.line(fmt::format("  values at the corners, * inside ({}):", values_from));
    add_values(cell, answer);
    std::vector<Answer> corners;
    for (const CornerFacts& corner : cell.corners) {
        corners.push_back(answer_of(corner));
    }
    const std::string piece =
        cell.origin.piece > 0 ? fmt::format(", piece {} after clipping", cell.origin.piece) : "";
    answer.data("triangle_count", cell.triangle_count)
        .line(fmt::format("  triangle {} of {} (counted from 0){}; its corners:", n.triangle,
                          cell.triangle_count, piece))
        .list("corners", std::move(corners))
        .data("hit_voxel", point(cell.hit_voxel))
        .data("hit_mm", point(cell.hit_mm));
    if (!cell.doubt.empty()) {
        answer.line("  doubtful: " + cell.doubt).data("doubt", cell.doubt);
    }
    return answer;
}

Fields state_fields(const PixelState& s) {
    return Answer()
        .data("enabled", s.enabled)
        .data("surface_field", s.surface)
        .data("z", s.z)
        .data("normal", s.normal)
        .data("rgb", s.rgb)
        .fields();
}

Answer answer_of(const ShownSurface& s) {
    Answer answer;
    answer.data("surface", s.index)
        .data("id", s.id)
        .data("revision", s.revision)
        .data("color", s.color)
        .data("cull_back", s.cull_back)
        .data("opacity", s.opacity)
        .data("rim", s.rim)
        .data_if("isovalue", s.isovalue);
    if (s.plane) {
        answer.data("slice", Fields{{"axis", std::string(1, "xyz"[s.plane->axis])},
                                    {"index", std::int64_t{s.plane->index}},
                                    {"black", s.plane->black},
                                    {"white", s.plane->white}});
    }
    return s.isovalue ? answer.data("table", gp::case_table(s.rule).name) : answer;
}

std::string place_text(const WhyFinding& f, const PrimitiveFacts& shown) {
    std::string text;
    if (shown.cell && shown.cell->unknown.empty()) {
        text += fmt::format("in the patient   {} (voxel {})\n", patient_text(shown.cell->hit_mm),
                            point_text(shown.cell->hit_voxel));
    }
    if (shown.cell && !f.source.empty()) {
        text += fmt::format("scan             {}, between slices {} and {} (0 to {})\n", f.source,
                            shown.slab, shown.slab + 1, f.slices - 1);
    }
    if (shown.surface < f.surfaces.size()) {
        const ShownSurface& s = f.surfaces[shown.surface];
        text += fmt::format(
            "surface          {} in drawing order, id {}, revision {}, color #{:02x}{:02x}{:02x}",
            s.index, s.id, s.revision, s.color[0], s.color[1], s.color[2]);
        text +=
            s.opacity < full_opacity ? fmt::format(", opacity {}/{}", s.opacity, full_opacity) : "";
        text += s.rim > 0 ? fmt::format(", rim {}/{}", s.rim, max_rim) : "";
        text += s.plane ? fmt::format(
                              ", slice {} {}, black at {:g}, white at {:g}; its normals are gray "
                              "values\n",
                              "xyz"[s.plane->axis], s.plane->index, s.plane->black, s.plane->white)
                : s.isovalue ? fmt::format(", isovalue {:g}, table {}\n", *s.isovalue,
                                           gp::case_table(s.rule).name)
                             : "\n";
    }
    text += fmt::format("sent by          gp-{}, RegionPrograms sequence {}, clock {}, word {}\n",
                        shown.gp, shown.sequence, shown.clock, shown.gp_word);
    text += fmt::format("drawn by         renderer-{}, region ({}, {}), pixel ({}, {}) of it\n",
                        f.renderer, f.history.place.column, f.history.place.row,
                        f.history.x_in_region(), f.history.y_in_region());
    return text;
}

std::string write_text(const std::string& where, const PixelWrite& w) {
    std::string change;
    const auto note = [&](const char* name, const std::string& before, const std::string& after) {
        if (before != after) {
            change += fmt::format("{}{} {} -> {}", change.empty() ? "" : ", ", name, before, after);
        }
    };
    const PixelState &a = w.before, &b = w.after;
    note("surface field", std::to_string(a.surface), std::to_string(b.surface));
    note("z", std::to_string(a.z), std::to_string(b.z));
    for (std::size_t n = 0; n < 3; ++n) {
        note(std::array{"nx", "ny", "nz"}[n], std::to_string(a.normal[n]),
             std::to_string(b.normal[n]));
    }
    note("color", color_text(a.rgb), color_text(b.rgb));
    return fmt::format("  {:<34} {:<50} {}", where, w.text,
                       change.empty() ? "(same value)" : change);
}

/// Stores into a pixel, only for JSON.
std::vector<Answer> writes_of(const std::vector<PixelWrite>& writes) {
    std::vector<Answer> all;
    for (const PixelWrite& w : writes) {
        all.emplace_back()
            .data("at", w.at)
            .data("part", w.address.part)
            .data("word", w.address.word)
            .data("instruction", w.text)
            .data("before", state_fields(w.before))
            .data("after", state_fields(w.after));
    }
    return all;
}

std::string result_of(const PixelHistory& history, const PixelVisit& visit) {
    return history.is_shut_out(visit) ? "the stipple mask of its surface hides this pixel"
           : visit.writes.empty()
               ? fmt::format("lost to depth {}", visit.before.z)
               : fmt::format("stored: surface field {} -> {}, normal {} -> {}",
                             visit.before.surface, visit.after.surface,
                             triple_text(visit.before.normal), triple_text(visit.after.normal));
}

/// The first voxel of the square that a slice's triangle shows.
std::string square_text(const PrimitiveFacts& facts, const ShownSurface& surface,
                        const bus::schema::Origin& square) {
    const int k = surface.plane->axis == 2 ? surface.plane->index : static_cast<int>(facts.slab);
    return fmt::format("of a slice, voxel ({}, {}, {})", square.i(), square.j(), k);
}

std::string kind_without_cell(const WhyFinding& f, const PrimitiveFacts& facts,
                              const Primitive& primitive) {
    if (primitive.is_of_slice) {
        return primitive.square && facts.surface < f.surfaces.size()
                   ? square_text(facts, f.surfaces[facts.surface], *primitive.square)
                   : "of a slice";
    }
    return primitive.is_of_scene  ? "of an archive"
           : primitive.detail > 0 ? "simplified, of no cell"
                                  : "provenance not recorded";
}

Answer visit_of(const WhyFinding& f, std::size_t v) {
    const PixelVisit& visit = f.history.visits[v];
    const PrimitiveFacts& facts = f.facts[v];
    const Primitive& primitive = f.history.primitives[visit.primitive];
    const std::string what = facts.cell ? to_text(facts.cell->name)
                                        : fmt::format("primitive {}, {}", visit.primitive,
                                                      kind_without_cell(f, facts, primitive));
    Answer answer;
    answer
        .line(fmt::format("  {:<34} {:<38} depth {:>8}  {}", facts.address, what,
                          visit.z ? fmt::format("{}", *visit.z) : "no test",
                          result_of(f.history, visit)))
        .data("primitive", visit.primitive)
        .data("address", facts.address)
        .data("gp", facts.gp)
        .data("gp_word", facts.gp_word)
        .data("sequence", facts.sequence)
        .data("clock", facts.clock)
        .data("surface", facts.surface)
        .data("slab", facts.slab)
        .data("stored", !visit.writes.empty())
        .data("shut_out", f.history.is_shut_out(visit))
        .data("before", state_fields(visit.before))
        .data("after", state_fields(visit.after))
        .list("writes", writes_of(visit.writes))
        .data_if("z", visit.z);
    return facts.cell ? answer.data("cell", answer_of(*facts.cell, f.values_from).fields())
                      : answer;
}

/// The pixel's visits and stores, as text and as data.
void add_history(const WhyFinding& f, Answer& answer) {
    const PixelHistory& h = f.history;
    std::vector<Answer> visits;
    for (std::size_t v = 0; v < h.visits.size(); ++v) {
        visits.push_back(visit_of(f, v));
    }
    answer
        .line(fmt::format("history of the pixel: {} of the {} primitives of the region cover the "
                          "pixel (depth 0 is in front)",
                          h.visits.size(), h.primitives.size()))
        .data("primitives_in_region", h.primitives.size())
        .list("prologue", writes_of(h.prologue))
        .list("visits", std::move(visits))
        .list("doors", writes_of(h.doors))
        .list("end_of_region", writes_of(h.end_of_region))
        .data("color", h.color);
    if (const PixelVisit* shown = h.shown()) {
        answer.data("shown", shown - h.visits.data())
            .line("stores of the visible primitive, instruction by instruction");
        const std::size_t first = h.primitives[shown->primitive].first_word;
        for (const PixelWrite& write : shown->writes) {
            answer.line(write_text(
                fmt::format("{} (+{})", f.shown()->address, write.address.word - first), write));
        }
    }
    const bool same = h.sent && (*h.sent & 0xFFFFFF) == (h.color & 0xFFFFFF);
    answer.data_if("recorded_color", h.sent)
        .line(fmt::format("end of region: {} stores into this pixel; it was sent as {}{}",
                          h.end_of_region.size(), color_text(h.color),
                          !h.sent ? ""
                          : same  ? ", as in the recorded frame (letters, scale bar and legend "
                                    "lie on top of saved pictures)"
                                  : "; the RECORDED frame has " + color_text(*h.sent)));
}

/// The end of a sentence if stipple masks hide transparent surfaces at the pixel.
std::string shut_out_text(std::size_t count) {
    return count == 0 ? ""
                      : fmt::format(
                            ", except {} of transparent surfaces whose stipple masks hide "
                            "this pixel",
                            count);
}

}  // namespace

std::string to_text(const TriangleName& name) {
    return fmt::format("triangle {} of cell ({}, {}, {})", name.triangle, name.i, name.j, name.k);
}

std::string surface_text(const std::vector<ShownSurface>& surfaces, std::uint32_t index) {
    if (index >= surfaces.size()) {
        return fmt::format("surface {}", index);
    }
    const auto& isovalue = surfaces[index].isovalue;
    return fmt::format("surface {}", index) +
           (isovalue ? fmt::format(" (isovalue {:g})", *isovalue) : "");
}

std::string sentence_of(const WhyFinding& f) {
    const PixelHistory& h = f.history;
    const std::string pixel = fmt::format("Pixel ({}, {}) of frame {}", h.x, h.y, f.frame);
    const PrimitiveFacts* shown = f.shown();
    if (shown == nullptr) {
        return fmt::format(
            "{} shows the background, {}: {}.", pixel, color_text(h.color),
            h.primitives.empty() ? "its region has no primitive"
            : h.visits.empty()
                ? fmt::format("none of its region's {} primitives covers the pixel",
                              h.primitives.size())
                : "no primitive stored into the pixel" + shut_out_text(h.visits.size()));
    }
    const std::string what =
        shown->cell ? fmt::format("{}: {}", surface_text(f.surfaces, shown->surface),
                                  to_text(shown->cell->name))
                    : fmt::format("{}: primitive {}", surface_text(f.surfaces, shown->surface),
                                  h.shown()->primitive);
    bool nearest = true;
    std::size_t let_in = 0;
    for (const PixelVisit& visit : h.visits) {
        if (!h.is_shut_out(visit)) {
            ++let_in;
            nearest = nearest && visit.z && h.shown()->z && *visit.z >= *h.shown()->z;
        }
    }
    const std::string rank =
        (let_in == 1 ? "the only one that covers it"
                     : fmt::format("the {} of {} that cover it",
                                   nearest ? "nearest" : "last stored", let_in)) +
        shut_out_text(h.visits.size() - let_in);
    return fmt::format("{} shows {}, which gp-{} sent, {}.", pixel, what, shown->gp, rank);
}

Answer answer_of(const TriangleName& name) {
    return Answer()
        .data("surface", name.surface)
        .data("cell", std::array{name.i, name.j, name.k})
        .data("triangle", name.triangle);
}

Answer answer_of(const WhyFinding& f) {
    const PixelHistory& h = f.history;
    std::vector<Answer> surfaces;
    for (const ShownSurface& surface : f.surfaces) {
        surfaces.push_back(answer_of(surface));
    }
    Answer answer;
    answer.line(sentence_of(f))
        .line("")
        .data("sentence", sentence_of(f))
        .data("frame", f.frame)
        .data("x", h.x)
        .data("y", h.y)
        .data("region", h.place.number)
        .data("renderer", f.renderer)
        .data("source", f.source)
        .data("values_from", f.values_from)
        .data("slices", f.slices)
        .list("surfaces", std::move(surfaces));
    if (const PrimitiveFacts* shown = f.shown()) {
        answer.line(place_text(f, *shown));
        if (shown->cell) {
            answer.object("", answer_of(*shown->cell, f.values_from)).line("");
        }
    }
    add_history(f, answer);
    return answer;
}

}  // namespace pxpl5::host::inspect
