#include "host/surface/blocks/block_gather.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cassert>
#include <glm/common.hpp>
#include <utility>

#include "host/base/error.hpp"
#include "ringbus/rules/slabs.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

[[noreturn]] void refuse_part(const std::string& reason) {
    throw RequestError(ExitCode::failed, reason);
}

bool same_bits(const schema::MeshVertex& a, const schema::MeshVertex& b) {
    using glm::floatBitsToUint;
    const auto bits = [](const schema::MeshVertex& v) {
        return std::pair(floatBitsToUint(glm::vec3(v.x(), v.y(), v.z())),
                         floatBitsToUint(glm::vec3(v.nx(), v.ny(), v.nz())));
    };
    return bits(a) == bits(b);
}

/// A vertex of a block.
struct BlockVertex {
    std::uint64_t key = 0;
    std::uint32_t block = 0, index = 0;
};

}  // namespace

BlockGather::BlockGather(const Wanted& wanted)
    : wanted_(wanted),
      blocks_(static_cast<std::size_t>((wanted.nz - 1 + block_slabs - 1) / block_slabs)) {}

void BlockGather::add(const bus::Message& message) {
    const auto* part = message.as<schema::MeshPart>();
    assert(part != nullptr);
    if (part->surface() != wanted_.surface || part->revision() != wanted_.revision ||
        part->detail() != wanted_.detail) {
        refuse_part(fmt::format(
            "mesh of surface {} revision {} detail {} from node {}, expected {} revision {} detail "
            "{}",
            part->surface(), part->revision(), part->detail(), message.source(), wanted_.surface,
            wanted_.revision, wanted_.detail));
    }
    messages_.push_back(message);
    moved_mm_ = std::max(moved_mm_, part->moved_mm());
    for (const schema::SlabMesh* mesh : *part->slabs()) {
        const std::uint32_t number = mesh->slab() / block_slabs;
        if (mesh->slab() % block_slabs != 0 || number >= blocks_.size()) {
            refuse_part(
                fmt::format("block at slab {} from node {}; the volume has {} blocks of {} "
                            "slabs",
                            mesh->slab(), message.source(), blocks_.size(), block_slabs));
        }
        if (std::exchange(blocks_[number], mesh) != nullptr) {
            refuse_part(fmt::format("block at slab {} came twice, from node {} the second time",
                                    mesh->slab(), message.source()));
        }
    }
}

SimplifiedMesh BlockGather::finish() {
    const auto gap = std::ranges::find(blocks_, nullptr);
    if (gap != blocks_.end()) {
        refuse_part(fmt::format("block at slab {} is missing, of {} blocks",
                                (gap - blocks_.begin()) * block_slabs, blocks_.size()));
    }
    std::vector<BlockVertex> vertices;
    std::size_t triangles = 0;
    for (std::uint32_t b = 0; b < blocks_.size(); ++b) {
        const auto& keys = *blocks_[b]->keys();
        for (std::uint32_t i = 0; i < keys.size(); ++i) {
            vertices.push_back({keys[i], b, i});
        }
        triangles += blocks_[b]->indices()->size() / 3;
    }
    std::ranges::sort(vertices, [](const BlockVertex& l, const BlockVertex& r) {
        return std::pair(l.key, l.block) < std::pair(r.key, r.block);
    });

    SimplifiedMesh out{{}, moved_mm_};
    WeldedMesh& mesh = out.mesh;
    std::vector<std::vector<std::uint32_t>> number_of(blocks_.size());
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
        number_of[b].resize(blocks_[b]->keys()->size());
    }
    const schema::MeshVertex* last = nullptr;
    for (const BlockVertex& v : vertices) {
        const schema::MeshVertex* here = blocks_[v.block]->vertices()->Get(v.index);
        if (mesh.keys.empty() || mesh.keys.back() != v.key) {
            mesh.keys.push_back(v.key);
            mesh.p_grid.emplace_back(here->x(), here->y(), here->z());
            mesh.normals.emplace_back(here->nx(), here->ny(), here->nz());
            last = here;
        } else if (!same_bits(*last, *here)) {
            refuse_part(fmt::format(
                "vertex key {}: is at {} {} {} in the block at slab {}, and at {} {} {} in the "
                "block below",
                v.key, here->x(), here->y(), here->z(), v.block * block_slabs, last->x(), last->y(),
                last->z()));
        }
        number_of[v.block][v.index] = static_cast<std::uint32_t>(mesh.keys.size() - 1);
    }
    mesh.triangles.reserve(triangles);
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
        const auto& indices = *blocks_[b]->indices();
        const std::vector<std::uint32_t>& number = number_of[b];
        mesh.slabs.push_back({static_cast<std::uint32_t>(b) * block_slabs, mesh.triangles.size(),
                              indices.size() / 3});
        for (std::uint32_t i = 0; i + 2 < indices.size(); i += 3) {
            mesh.triangles.push_back(
                {number[indices[i]], number[indices[i + 1]], number[indices[i + 2]]});
        }
    }
    blocks_.assign(blocks_.size(), nullptr);
    messages_.clear();
    return out;
}

}  // namespace pxpl5::host
