// What `why` says, for people.
#include <fmt/format.h>

#include "host/inspect/why/why.hpp"
#include "host/inspect/why/why_fields.hpp"

namespace pxpl5::host::inspect {

namespace {

std::string colour_text(std::uint32_t rgb) {
    return fmt::format("#{:02x}{:02x}{:02x}", rgb & 0xFF, rgb >> 8 & 0xFF, rgb >> 16 & 0xFF);
}

std::string point_text(const glm::dvec3& p) {
    return fmt::format("({:.3f}, {:.3f}, {:.3f})", p.x, p.y, p.z);
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

std::string cell_text(const CellFacts& cell, const std::string& values_from) {
    const TriangleName& n = cell.name;
    std::string text =
        fmt::format("cell ({}, {}, {}): case {} (inside corners: {}), joined faces: {}\n", n.i, n.j,
                    n.k, cell.origin.inside, bits_text(cell.origin.inside, "none"),
                    bits_text(cell.origin.joined, "none"));
    if (!cell.unknown.empty()) {
        return text + fmt::format("  its voxels are not known: {}\n", cell.unknown);
    }
    text += fmt::format("  values at the corners, * inside ({}):\n", values_from);
    text += fmt::format("  {:>18}{:>12}{:>12}\n", "", fmt::format("i = {}", n.i),
                        fmt::format("i = {}", n.i + 1));
    for (int row = 0; row < 4; ++row) {
        text +=
            fmt::format("  {:<18}", fmt::format("slice {}, j = {}", n.k + row / 2, n.j + row % 2));
        for (const int c : {2 * row, 2 * row + 1}) {
            text += fmt::format("{:>11g}{}", cell.values[static_cast<std::size_t>(c)],
                                (cell.origin.inside >> c & 1) != 0 ? '*' : ' ');
        }
        text += '\n';
    }
    text += fmt::format(
        "  triangle {} of {} (counted from 0){}; its corners:\n", n.triangle, cell.triangle_count,
        cell.origin.piece > 0 ? fmt::format(", piece {} after clipping", cell.origin.piece) : "");
    for (const CornerFacts& corner : cell.corners) {
        const auto voxel = [](const std::array<int, 3>& v) {
            return fmt::format("({}, {}, {})", v[0], v[1], v[2]);
        };
        text += corner.is_centre
                    ? fmt::format("    the middle of the cell's crossings at voxel {}\n",
                                  point_text(corner.p_voxel))
                    : fmt::format("    {:.4f} of the way from {} = {:g} to {} = {:g}\n",
                                  corner.fraction, voxel(corner.voxel_0), corner.value_0,
                                  voxel(corner.voxel_1), corner.value_1);
    }
    if (!cell.doubt.empty()) {
        text += fmt::format("  doubtful: {}\n", cell.doubt);
    }
    return text;
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
            "surface          {} in drawing order, id {}, revision {}, colour #{:02x}{:02x}{:02x}",
            s.index, s.id, s.revision, s.colour[0], s.colour[1], s.colour[2]);
        text += s.isovalue ? fmt::format(", isovalue {:g}, table {}\n", *s.isovalue,
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

std::string visit_text(const WhyFinding& f, std::size_t v) {
    const PixelVisit& visit = f.history.visits[v];
    const PrimitiveFacts& facts = f.facts[v];
    const std::string depth = visit.z ? fmt::format("{}", *visit.z) : "no test";
    const std::string what = facts.cell
                                 ? to_text(facts.cell->name)
                                 : fmt::format("primitive {}, {}", visit.primitive,
                                               f.history.primitives[visit.primitive].is_of_scene
                                                   ? "of an archive"
                                                   : "origin not recorded");
    const auto normal = [](const PixelState& s) {
        return fmt::format("({}, {}, {})", s.normal[0], s.normal[1], s.normal[2]);
    };
    const std::string result =
        f.history.is_shut_out(visit) ? "its surface's screen door is shut here"
        : visit.writes.empty()
            ? fmt::format("lost, {} is there", visit.before.z)
            : fmt::format("stored: surface field {} -> {}, normal {} -> {}", visit.before.surface,
                          visit.after.surface, normal(visit.before), normal(visit.after));
    return fmt::format("  {:<34} {:<38} depth {:>8}  {}\n", facts.address, what, depth, result);
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
    note("colour", colour_text(a.rgb), colour_text(b.rgb));
    return fmt::format("  {:<34} {:<50} {}\n", where, w.text,
                       change.empty() ? "(same value)" : change);
}

std::string history_text(const WhyFinding& f) {
    const PixelHistory& h = f.history;
    std::string text = fmt::format(
        "history of the pixel: {} of the region's {} primitives cover it (depth 0 is in front)\n",
        h.visits.size(), h.primitives.size());
    for (std::size_t v = 0; v < h.visits.size(); ++v) {
        text += visit_text(f, v);
    }
    if (const PixelVisit* shown = h.shown()) {
        text += "what the primitive that is shown stored, instruction by instruction\n";
        for (const PixelWrite& write : shown->writes) {
            text +=
                write_text(f.shown()->address +
                               fmt::format(" (+{})", write.address.word -
                                                         h.primitives[shown->primitive].first_word),
                           write);
        }
    }
    text += fmt::format("end of region: {} stores into this pixel; it was sent as {}",
                        h.end_of_region.size(), colour_text(h.colour));
    if (h.sent) {
        text += (*h.sent & 0xFFFFFF) == (h.colour & 0xFFFFFF)
                    ? ", as in the recorded picture"
                    : fmt::format("; the RECORDED picture has {}", colour_text(*h.sent));
    }
    return text;
}

/// What is added to a sentence if transparent surfaces leave the pixel to what is behind.
std::string shut_out_text(std::size_t count) {
    return count == 0 ? ""
                      : fmt::format(
                            ", but for {} of transparent surfaces that leave this pixel to "
                            "what is behind them",
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
            "{} shows the background, {}: {}.", pixel, colour_text(h.colour),
            h.primitives.empty() ? "its region has no primitive"
            : h.visits.empty()
                ? fmt::format("none of its region's {} primitives covers it", h.primitives.size())
                : "nothing is stored in it" + shut_out_text(h.visits.size()));
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

Reply why_reply(const WhyFinding& f) {
    std::string text = sentence_of(f) + "\n\n";
    if (const PrimitiveFacts* shown = f.shown()) {
        text += place_text(f, *shown) + '\n';
        if (shown->cell) {
            text += cell_text(*shown->cell, f.values_from) + '\n';
        }
    }
    return {text + history_text(f), why_fields(f)};
}

}  // namespace pxpl5::host::inspect
