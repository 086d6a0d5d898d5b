#include "host/inspect/diff/draw_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace pxpl5::host::inspect {

namespace {

namespace schema = bus::schema;

std::string text_of(const schema::Matrix& matrix) {
    return fmt::format("{}", fmt::join(matrix.m()->begin(), matrix.m()->end(), " "));
}

std::string text_of(const schema::Rgb& c) {
    return fmt::format("#{:02x}{:02x}{:02x}", c.r(), c.g(), c.b());
}

/// Adds "`name` count" and each element's values.
template <typename Vector, typename Add>
void add_each(NamedValues& values, const std::string& name, const Vector* vector, const Add& add) {
    const std::uint32_t count = vector == nullptr ? 0 : vector->size();
    values.emplace_back(name + "s", fmt::format("{}", count));
    for (std::uint32_t i = 0; i < count; ++i) {
        add(fmt::format("{} {}", name, i), *vector->Get(i));
    }
}

}  // namespace

NamedValues values_of(const schema::DrawFrame& draw) {
    NamedValues values = {{"size", fmt::format("{} x {}", draw.width(), draw.height())}};
    const auto add = [&](const std::string& name, const std::string& text) {
        values.emplace_back(name, text);
    };
    add("sample", fmt::format("{} of {}", draw.sample() + 1, draw.samples()));
    add_each(values, "view", draw.views(), [&](const std::string& name, const schema::View& v) {
        add(name + "'s voxel to eye", text_of(*v.voxel_to_eye()));
        add(name + "'s projection", text_of(*v.projection()));
    });
    add_each(values, "light", draw.lights(), [&](const std::string& name, const schema::Light& l) {
        const schema::Vec3& d = l.direction();
        add(name, fmt::format("({}, {}, {}), {}", d.x(), d.y(), d.z(), l.intensity()));
    });
    add("ambient", fmt::format("{}", draw.ambient()));
    add("specular", fmt::format("{} to the power of {}", draw.specular(), draw.specular_power()));
    add("background", draw.background() == nullptr ? "none" : text_of(*draw.background()));
    add_each(values, "surface", draw.surfaces(),
             [&](const std::string& name, const schema::SurfaceDraw& s) {
                 add(name,
                     fmt::format("id {}, revision {}, color {}, {}, opacity {}, detail {}, rim {}",
                                 s.surface(), s.revision(), text_of(s.color()),
                                 s.cull_back() ? "front only" : "both sides", s.opacity(),
                                 s.detail(), s.rim()));
             });
    add_each(values, "slice plane", draw.planes(),
             [&](const std::string& name, const schema::SlicePlane& p) {
                 add(name, fmt::format("{} {}, black at {}, white at {}", "xyz"[p.axis()],
                                       p.index(), p.black(), p.white()));
             });
    add_each(values, "clip plane", draw.clip_planes(),
             [&](const std::string& name, const schema::ClipPlane& p) {
                 add(name, fmt::format("({}, {}, {}, {})", p.a(), p.b(), p.c(), p.d()));
             });
    return values;
}

NamedValues setup_values_of(const bus::Message& message) {
    if (const auto* v = message.as<schema::VolumeHeader>()) {
        return {{"volume size", fmt::format("{} x {} x {}", v->nx(), v->ny(), v->nz())},
                {"volume type", enum_name(v->type())},
                {"volume's place in the patient", text_of(*v->voxel_to_patient())},
                {"volume's values", fmt::format("{} .. {}", v->minimum(), v->maximum())},
                {"volume's digest", fmt::format("{:016x}", v->digest())}};
    }
    if (const auto* s = message.as<schema::SetSurface>()) {
        return {{"surface set", fmt::format("id {}, revision {}", s->surface(), s->revision())},
                {"isovalue", fmt::format("{}", s->isovalue())},
                {"case table", enum_name(s->table())}};
    }
    if (const auto* removed = message.as<schema::RemoveSurface>()) {
        return {{"surface removed", fmt::format("id {}", removed->surface())}};
    }
    return {};
}

}  // namespace pxpl5::host::inspect
