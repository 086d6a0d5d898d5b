// Meshes for the host as the GPs would send them.
#pragma once

#include <cmath>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include "host/surface/certificate.hpp"
#include "host/surface/components.hpp"
#include "host/surface/mesh_gather.hpp"
#include "ringbus/message.hpp"
#include "tests/gp_firmware/test_volume.hpp"

namespace pxpl5::test {

using Slabs = std::vector<gp::SlabMesh>;

inline constexpr std::uint16_t test_surface = 3;
inline constexpr std::uint32_t test_revision = 7;

inline host::VolumeGrid grid_of(const gp::VolumeShape& shape) {
    return {shape.nx, shape.ny, shape.nz, shape.voxel_to_patient, shape.slice_places};
}

inline std::unique_ptr<bus::schema::SlabMeshT> to_wire(const gp::SlabMesh& mesh) {
    auto slab = std::make_unique<bus::schema::SlabMeshT>();
    slab->slab = static_cast<std::uint32_t>(mesh.slab);
    slab->keys = mesh.keys;
    slab->indices = mesh.indices;
    for (const gp::Vertex& v : mesh.vertices) {
        const auto n = [&](std::size_t i) { return float(v.normal[i]) / gp::normal_one; };
        slab->vertices.emplace_back(v.p_voxel.x, v.p_voxel.y, v.p_voxel.z, n(0), n(1), n(2));
    }
    for (const gp::Origin& o : mesh.origins)
        slab->origins.emplace_back(o.i, o.j, o.inside, o.joined, o.triangle, o.piece);
    return slab;
}

/// Returns the part as a message from GP `source`.
inline bus::Message message_of(const bus::schema::MeshPartT& part, bus::NodeId source = 1) {
    const bus::Payload payload = bus::pack(part);
    const bus::schema::Header header(bus::header_magic, bus::protocol_version,
                                     static_cast<std::uint16_t>(payload.kind()), source,
                                     bus::host_id, 0, 0, 0, payload.bytes().size(), 0, 0, 0);
    const auto owner = std::make_shared<std::vector<std::uint64_t>>(payload.bytes().size() / 8 + 1);
    std::memcpy(owner->data(), payload.bytes().data(), payload.bytes().size());
    const std::span body(reinterpret_cast<const std::uint8_t*>(owner->data()),
                         payload.bytes().size());
    return {header, body, owner};
}

inline bus::schema::MeshPartT empty_part() {
    bus::schema::MeshPartT part;
    part.surface = test_surface;
    part.revision = test_revision;
    return part;
}

/// The slabs as `gp_count` GPs send them, one message each.
inline std::vector<bus::Message> messages_of(std::span<const gp::SlabMesh> slabs,
                                             std::size_t gp_count = 1) {
    std::vector<bus::Message> messages;
    for (std::size_t gp = 0; gp < gp_count; ++gp) {
        bus::schema::MeshPartT part = empty_part();
        for (std::size_t s = gp; s < slabs.size(); s += gp_count)
            part.slabs.push_back(to_wire(slabs[s]));
        messages.push_back(message_of(part, static_cast<bus::NodeId>(gp + 1)));
    }
    return messages;
}

inline host::WeldedMesh gather(std::span<const bus::Message> messages, const host::VolumeGrid& grid,
                               const host::Pause& pause = {}) {
    host::MeshGather gather(grid, test_surface, test_revision);
    for (const bus::Message& message : messages) gather.add(message);
    return gather.finish(pause);
}

/// With the cells of triangles.
/// store  Owns all slabs.
inline Slabs extract_slabs(const gp::SliceStore& store, double isovalue,
                           CaseRule rule = CaseRule::watertight) {
    Slabs slabs(static_cast<std::size_t>(store.shape().slab_count()));
    for (const int slab : store.slabs())
        gp::extract_slab(store, slab, isovalue, gp::case_table(rule),
                         slabs[static_cast<std::size_t>(slab)], true);
    return slabs;
}
inline Slabs extract_slabs(const Volume& volume, double isovalue,
                           CaseRule rule = CaseRule::watertight) {
    return extract_slabs(Gp(volume, {0, 1}).store, isovalue, rule);
}

inline host::WeldedMesh mesh_of(const Volume& volume, double isovalue,
                                CaseRule rule = CaseRule::watertight) {
    return gather(messages_of(extract_slabs(volume, isovalue, rule)), grid_of(volume.shape));
}

/// The volume for the host.
inline host::Volume for_host(const Volume& volume) {
    host::Volume out;
    out.nx = volume.shape.nx;
    out.ny = volume.shape.ny;
    out.nz = volume.shape.nz;
    out.type = static_cast<Scalar>(volume.shape.type);
    out.voxel_to_patient = volume.shape.voxel_to_patient;
    out.minimum = volume.shape.minimum;
    out.maximum = volume.shape.maximum;
    out.values = volume.values;
    return out;
}

/// A field of whole numbers 0 .. levels - 1.
template <class Random>
Volume random_volume(Size size, Scalar type, unsigned levels, Random& random) {
    return make_volume(size, type, [&](int, int, int) { return double(random() % levels); });
}

/// A float volume of field(p_mm) with steps in mm along the columns, its middle voxel at the
/// patient's origin.
template <class Field>
Volume placed_volume(Size size, const glm::dmat3& steps, Field field) {
    glm::dmat4 m(steps);
    m[3] = glm::dvec4(-(steps * glm::dvec3(size.nx / 2, size.ny / 2, size.nz / 2)), 1);
    Volume volume = make_volume(size, Scalar::float32, [&](int x, int y, int z) {
        return field(glm::dvec3(m * glm::dvec4(x, y, z, 1)));
    });
    volume.shape.voxel_to_patient = m;
    return volume;
}

/// A surface with its components.
struct Parts {
    host::VolumeGrid grid;
    host::WeldedMesh mesh;
    host::MeshComponents parts;
};

inline Parts parts_of(const Volume& volume, double isovalue) {
    Parts out;
    out.grid = grid_of(volume.shape);
    out.mesh = mesh_of(volume, isovalue);
    out.parts = host::find_components(out.mesh, out.grid);
    return out;
}

inline host::Certificate certify_volume(const Volume& volume, double isovalue,
                                        CaseRule rule = CaseRule::watertight) {
    return host::certify(mesh_of(volume, isovalue, rule), grid_of(volume.shape));
}

/// 3x3x3 voxels of nothing but the middle one.
inline Volume one_voxel(double value) {
    return make_volume({3, 3, 3}, Scalar::int16, [&](int x, int y, int z) {
        return x == 1 && y == 1 && z == 1 ? value : 0.0;
    });
}

/// The sum over the GPs' slabs.
struct GpSums {
    double area_mm2 = 0, volume_mm3 = 0;
    std::int64_t triangles = 0, vertices = 0;
};
inline GpSums sums_of(std::span<const gp::SlabMesh> slabs) {
    GpSums sums;
    for (const gp::SlabMesh& slab : slabs) {
        sums.area_mm2 += slab.counts.area_mm2;
        sums.volume_mm3 += slab.counts.volume_mm3;
        sums.triangles += slab.counts.triangles;
        sums.vertices += slab.counts.vertices;
    }
    return sums;
}

}  // namespace pxpl5::test
