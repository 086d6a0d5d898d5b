#include "host/io/archive_requests.hpp"

#include <algorithm>
#include <limits>
#include <memory>
#include <new>
#include <string>
#include <utility>

#include "host/base/error.hpp"
#include "host/phigs/content.hpp"
#include "host/scene/camera.hpp"

namespace pxpl5::host::io {

namespace {

namespace schema = bus::schema;

/// An archive's y is up, and its viewer is on the positive z axis: view `anterior`.
glm::dvec3 to_patient_axes(const glm::dvec3& v) {
    return {v.x, -v.z, v.y};
}

struct Float3 {
    float x, y, z;
};

Float3 to_float(const glm::dvec3& v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// Moves an archive's coordinates to the millimeters at which every archive is shown.
class Placing {
  public:
    explicit Placing(const phigs::Content& content)
        : middle_(content.middle()),
          scale_(content.radius > 0 ? scene_radius_mm / content.radius : 1.0) {}

    Float3 place_mm(const glm::dvec3& p) const {
        return to_float(to_patient_axes((p - middle_) * scale_));
    }
    /// A sphere that is too small for a float stays a sphere.
    float radius_mm(double radius) const {
        return std::max(static_cast<float>(radius * scale_), std::numeric_limits<float>::min());
    }

  private:
    glm::dvec3 middle_;
    double scale_;
};

std::unique_ptr<schema::ScenePartT> wire_part(const phigs::Part& part, const Placing& placing) {
    auto wire = std::make_unique<schema::ScenePartT>();
    wire->surface = static_cast<std::uint16_t>(part.material);
    wire->vertices.reserve(part.vertices.size());
    for (const phigs::ContentVertex& v : part.vertices) {
        const Float3 p = placing.place_mm(v.p), n = to_float(to_patient_axes(v.normal));
        wire->vertices.emplace_back(p.x, p.y, p.z, n.x, n.y, n.z);
    }
    wire->indices = part.indices;
    for (const phigs::ContentSphere& s : part.spheres) {
        const Float3 p = placing.place_mm(s.center);
        wire->spheres.emplace_back(p.x, p.y, p.z, placing.radius_mm(s.radius));
    }
    for (const phigs::ContentLine& l : part.lines) {
        const Float3 a = placing.place_mm(l.from), b = placing.place_mm(l.to);
        wire->lines.emplace_back(a.x, a.y, a.z, b.x, b.y, b.z);
    }
    return wire;
}

std::unique_ptr<schema::ScenePoint> wire_point(const glm::dvec3& p) {
    return std::make_unique<schema::ScenePoint>(p.x, p.y, p.z);
}

schema::ArchiveContentT wire_content(const phigs::Content& content) {
    schema::ArchiveContentT wire;
    for (const phigs::Material& material : content.materials) {
        const Color& c = material.color;
        wire.materials.emplace_back(schema::Rgb(c.r, c.g, c.b), material.cull_back);
    }
    const Placing placing(content);
    for (const phigs::Part& part : content.parts) {
        const auto slab = static_cast<std::uint32_t>(wire.parts.size());
        wire.parts.push_back(wire_part(part, placing));
        wire.parts.back()->slab = slab;
    }
    wire.low = wire_point(content.low);
    wire.high = wire_point(content.high);
    wire.structures = static_cast<std::uint32_t>(content.structures);
    wire.posted = static_cast<std::uint32_t>(content.posted);
    wire.polygons = static_cast<std::uint32_t>(content.polygons);
    if (content.has_specular) {
        const auto& [r, g, b] = content.specular.rgb;
        wire.specular = (r + g + b) / 3 / 255;
        wire.specular_power = static_cast<std::uint32_t>(
            std::clamp(content.specular.power, 1.0, double{max_specular_power}));
    }
    wire.notes = content.notes;
    return wire;
}

std::vector<bus::Payload> refusal(const std::string& reason, bool bad_data) {
    schema::IoDoneT done;
    done.error = reason;
    done.bad_data = bad_data;
    return {bus::pack(done)};
}

}  // namespace

std::vector<bus::Payload> read_archive_file(const schema::ReadArchive& request) {
    const std::string path = request.path()->str();
    try {
        const phigs::Content content = phigs::flatten(phigs::read_archive(path));
        schema::IoDoneT done;
        done.ok = true;
        return {bus::pack(wire_content(content)), bus::pack(done)};
    } catch (const RequestError& error) {
        return refusal(error.what(), error.code == ExitCode::bad_data);
    } catch (const std::bad_alloc&) {
        return refusal(path + ": does not fit in the memory that the io process may use", true);
    }
}

}  // namespace pxpl5::host::io
