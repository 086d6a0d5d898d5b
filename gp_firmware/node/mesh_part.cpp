#include "gp_firmware/node/mesh_part.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "gp_firmware/node/messages.hpp"
#include "ringbus/node.hpp"

namespace pxpl5::gp {

namespace {

namespace schema = bus::schema;

schema::MeshVertex to_wire(const Vertex& v) {
    return {v.p_voxel.x,
            v.p_voxel.y,
            v.p_voxel.z,
            static_cast<float>(v.normal[0]) / normal_one,
            static_cast<float>(v.normal[1]) / normal_one,
            static_cast<float>(v.normal[2]) / normal_one};
}

// Bytes that a table and a slab add to the data, with room for alignment.
constexpr std::size_t message_overhead_bytes = 256, slab_overhead_bytes = 96;

/// Returns the maximal size of a MeshPart.
std::size_t size_bytes(std::span<const SlabMesh> slabs, bool origins) {
    std::size_t bytes = message_overhead_bytes;
    for (const SlabMesh& mesh : slabs) {
        const MeshSize size = size_of(mesh);
        bytes += slab_overhead_bytes +
                 size.vertices * (sizeof(schema::MeshVertex) + sizeof(std::uint64_t)) +
                 3 * size.triangles * sizeof(std::uint32_t) +
                 (origins ? size.triangles * sizeof(schema::Origin) : 0);
    }
    return bytes;
}

}  // namespace

MeshPartBuilder::MeshPartBuilder(const MeshToSend& mesh)
    : builder_(size_bytes(mesh.slabs, mesh.origins)), all_(mesh) {
    const std::size_t bytes = size_bytes(mesh.slabs, mesh.origins);
    if (bytes > bus::max_body_bytes) {
        throw bus::NodeFault(
            schema::FaultCode::out_of_memory,
            fmt::format(
                "surface {}: one GP's part of the mesh has {} bytes, but a message has at most "
                "{}; use more GPs",
                mesh.surface, bytes, bus::max_body_bytes));
    }
}

void MeshPartBuilder::add(const SlabMesh& mesh, std::span<const Origin> origins) {
    schema::MeshVertex* vertices = nullptr;
    const auto vertices_at =
        builder_.CreateUninitializedVectorOfStructs(mesh.vertices.size(), &vertices);
    std::ranges::transform(mesh.vertices, vertices, [](const Vertex& v) { return to_wire(v); });
    const auto keys = builder_.CreateVector(mesh.keys);
    const auto indices = builder_.CreateVector(mesh.indices);
    slabs_.push_back(schema::CreateSlabMesh(builder_, static_cast<std::uint32_t>(mesh.slab),
                                            vertices_at, keys, indices,
                                            all_.origins ? origins_to_wire(builder_, origins) : 0));
}

bus::Payload MeshPartBuilder::finish() {
    const auto slabs = builder_.CreateVector(slabs_);
    return bus::finish(
        builder_, schema::CreateMeshPart(builder_, all_.surface, all_.revision, slabs,
                                         static_cast<std::uint8_t>(all_.detail), all_.moved_mm));
}

}  // namespace pxpl5::gp
