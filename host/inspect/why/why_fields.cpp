#include "host/inspect/why/why_fields.hpp"

#include <algorithm>

namespace pxpl5::host::inspect {

namespace {

template <typename T>
std::int64_t number(T value) {
    return static_cast<std::int64_t>(value);
}

std::vector<double> point(const glm::dvec3& p) {
    return {p.x, p.y, p.z};
}

std::vector<double> voxel(const std::array<int, 3>& v) {
    return {v.begin(), v.end()};
}

Fields state_fields(const PixelState& s) {
    return {{"enabled", s.enabled},
            {"surface_field", number(s.surface)},
            {"z", number(s.z)},
            {"normal", voxel(s.normal)},
            {"rgb", number(s.rgb)}};
}

std::vector<Fields> writes_fields(const std::vector<PixelWrite>& writes) {
    std::vector<Fields> all;
    for (const PixelWrite& w : writes) {
        all.push_back({{"at", number(w.at)},
                       {"part", number(w.address.part)},
                       {"word", number(w.address.word)},
                       {"instruction", w.text},
                       {"before", state_fields(w.before)},
                       {"after", state_fields(w.after)}});
    }
    return all;
}

Fields cell_fields(const CellFacts& c) {
    Fields fields = triangle_fields(c.name);
    fields.push_back({"case", number(c.origin.inside)});
    fields.push_back({"joined_faces", number(c.origin.joined)});
    fields.push_back({"piece", number(c.origin.piece)});
    if (!c.unknown.empty()) {
        fields.push_back({"unknown", c.unknown});
        return fields;
    }
    fields.push_back({"values", std::vector<double>(c.values.begin(), c.values.end())});
    fields.push_back({"triangle_count", number(c.triangle_count)});
    std::vector<Fields> corners;
    for (const CornerFacts& corner : c.corners) {
        Fields& f = corners.emplace_back();
        if (!corner.is_centre) {
            f = {{"voxel_0", voxel(corner.voxel_0)},
                 {"voxel_1", voxel(corner.voxel_1)},
                 {"value_0", corner.value_0},
                 {"value_1", corner.value_1},
                 {"fraction", corner.fraction}};
        }
        f.push_back({"voxel", point(corner.p_voxel)});
        f.push_back({"mm", point(corner.p_mm)});
    }
    fields.push_back({"corners", corners});
    fields.push_back({"hit_voxel", point(c.hit_voxel)});
    fields.push_back({"hit_mm", point(c.hit_mm)});
    if (!c.doubt.empty()) {
        fields.push_back({"doubt", c.doubt});
    }
    return fields;
}

Fields surface_fields(const ShownSurface& s) {
    Fields fields{{"surface", number(s.index)},
                  {"id", number(s.id)},
                  {"revision", number(s.revision)},
                  {"colour", std::vector<double>(s.colour.begin(), s.colour.end())},
                  {"cull_back", s.cull_back},
                  {"opacity", number(s.opacity)}};
    if (s.isovalue) {
        fields.push_back({"isovalue", *s.isovalue});
        fields.push_back({"table", std::string(gp::case_table(s.rule).name)});
    }
    return fields;
}

Fields visit_fields(const WhyFinding& f, std::size_t v) {
    const PixelVisit& visit = f.history.visits[v];
    const PrimitiveFacts& facts = f.facts[v];
    Fields fields{{"primitive", number(visit.primitive)},
                  {"address", facts.address},
                  {"gp", number(facts.gp)},
                  {"gp_word", number(facts.gp_word)},
                  {"sequence", number(facts.sequence)},
                  {"clock", number(facts.clock)},
                  {"surface", number(facts.surface)},
                  {"slab", number(facts.slab)},
                  {"stored", !visit.writes.empty()},
                  {"shut_out", f.history.is_shut_out(visit)},
                  {"before", state_fields(visit.before)},
                  {"after", state_fields(visit.after)},
                  {"writes", writes_fields(visit.writes)}};
    if (visit.z) {
        fields.push_back({"z", number(*visit.z)});
    }
    if (facts.cell) {
        fields.push_back({"cell", cell_fields(*facts.cell)});
    }
    return fields;
}

}  // namespace

Fields triangle_fields(const TriangleName& name) {
    return {{"surface", number(name.surface)},
            {"cell", std::vector<double>{static_cast<double>(name.i), static_cast<double>(name.j),
                                         static_cast<double>(name.k)}},
            {"triangle", number(name.triangle)}};
}

Fields why_fields(const WhyFinding& f) {
    const PixelHistory& h = f.history;
    std::vector<Fields> visits, surfaces;
    for (std::size_t v = 0; v < h.visits.size(); ++v) {
        visits.push_back(visit_fields(f, v));
    }
    std::ranges::transform(f.surfaces, std::back_inserter(surfaces), surface_fields);
    Fields fields{{"sentence", sentence_of(f)},
                  {"frame", number(f.frame)},
                  {"x", number(h.x)},
                  {"y", number(h.y)},
                  {"region", number(h.place.number)},
                  {"renderer", number(f.renderer)},
                  {"source", f.source},
                  {"values_from", f.values_from},
                  {"slices", number(f.slices)},
                  {"surfaces", surfaces},
                  {"primitives_in_region", number(h.primitives.size())},
                  {"prologue", writes_fields(h.prologue)},
                  {"visits", visits},
                  {"doors", writes_fields(h.doors)},
                  {"end_of_region", writes_fields(h.end_of_region)},
                  {"colour", number(h.colour)}};
    const PixelVisit* shown = h.shown();
    if (shown != nullptr) {
        fields.push_back({"shown", number(shown - h.visits.data())});
    }
    if (h.sent) {
        fields.push_back({"recorded_colour", number(*h.sent)});
    }
    return fields;
}

}  // namespace pxpl5::host::inspect
