#include "host/surface/mesh_gather.hpp"

#include <fmt/core.h>
#include <glm/common.hpp>

#include <algorithm>
#include <bit>
#include <cassert>
#include <limits>
#include <utility>

#include "host/base/error.hpp"

namespace pxpl5::host {

namespace schema = bus::schema;

namespace {

constexpr std::size_t max_vertices = std::numeric_limits<std::uint32_t>::max();

[[noreturn]] void refuse_mesh_part(const std::string& reason) {
    throw RequestError(ExitCode::failed, reason);
}

/// The keys of one slice, as bits: a key's vertex is the number of keys below it.
class SliceKeys {
  public:
    explicit SliceKeys(std::size_t key_count)
        : words_((key_count + 63) / 64), ranks_(words_.size()) {}

    void clear() { std::fill(words_.begin(), words_.end(), std::uint64_t{0}); }
    void add(std::uint64_t key) { words_[key / 64] |= std::uint64_t{1} << key % 64; }

    /// Call it after the last add(). Returns the number of keys.
    std::size_t count() {
        std::uint32_t sum = 0;
        for (std::size_t w = 0; w < words_.size(); ++w) {
            ranks_[w] = sum;
            sum += static_cast<std::uint32_t>(std::popcount(words_[w]));
        }
        return sum;
    }
    std::uint32_t rank(std::uint64_t key) const {
        const std::uint64_t below = (std::uint64_t{1} << key % 64) - 1;
        return ranks_[key / 64] +
               static_cast<std::uint32_t>(std::popcount(words_[key / 64] & below));
    }

  private:
    std::vector<std::uint64_t> words_;
    std::vector<std::uint32_t> ranks_;
};

/// Goes up the slices: a slice's vertices come from the slab above it, which owns them, and from
/// the one below, which must agree on those that both see.
class Weld {
  public:
    Weld(const VolumeGrid& grid, const std::vector<const schema::SlabMesh*>& slabs, bool origins)
        : grid_(grid), slabs_(slabs), keys_(4 * grid.slice_voxels()) {
        std::size_t vertices = 0, triangles = 0;
        for (std::size_t s = 0; s < slabs.size(); ++s) {
            const auto& keys = *slabs[s]->keys();
            const std::uint64_t end = first_key(s + (s + 1 < slabs.size() ? 1 : 2));
            vertices += static_cast<std::size_t>(
                std::count_if(keys.begin(), keys.end(), [end](auto key) { return key < end; }));
            triangles += slabs[s]->indices()->size() / 3;
        }
        if (vertices > max_vertices) {
            refuse_mesh_part(
                fmt::format("the surface has {} vertices, more than {}", vertices, max_vertices));
        }
        mesh_.keys.reserve(vertices);
        mesh_.p_grid.reserve(vertices);
        mesh_.normals.reserve(vertices);
        mesh_.triangles.reserve(triangles);
        mesh_.slabs.reserve(slabs.size());
        mesh_.cells.reserve(origins ? triangles : 0);
    }

    WeldedMesh run(const Pause& pause) {
        constexpr std::size_t slices_per_pause = 16;  // 2^18 triangles of a large scan.
        for (std::size_t z = 0; z <= slabs_.size(); ++z) {
            pause_at(z, pause, slices_per_pause);
            weld_slice(z);
            if (z > 0) {
                append_triangles(z - 1);
            }
            std::swap(below_, above_);
        }
        return std::move(mesh_);
    }

  private:
    enum Seen : std::uint8_t { seen_above = 1, seen_below = 2 };

    std::uint64_t first_key(std::size_t slice) const { return 4 * grid_.slice_voxels() * slice; }

    std::string place_of(std::size_t slab, std::uint64_t key) const {
        const EdgePlace place = edge_place(key, grid_);
        return fmt::format(
            "slab {}, vertex key {} (voxel {} {} {}, {})", slab, key, place.voxel[0],
            place.voxel[1], place.voxel[2],
            std::string_view("xyzc").substr(static_cast<std::size_t>(place.axis), 1));
    }

    /// Throws unless the slab can have a vertex with this key.
    void check_key(std::size_t slab, std::uint64_t key) const {
        const bool lower = key >= first_key(slab) && key < first_key(slab + 1);
        const bool upper = !lower && key >= first_key(slab) && key < first_key(slab + 2);
        const std::uint64_t axis = key % 4;
        const std::uint64_t voxel = (key - first_key(slab + (upper ? 1 : 0))) / 4;
        const auto nx = static_cast<std::uint64_t>(grid_.nx);
        const bool last_x = voxel % nx == nx - 1;
        const bool last_y = voxel >= grid_.slice_voxels() - nx;
        const bool leaves =
            (axis == 0 && last_x) || (axis == 1 && last_y) || (axis == 3 && (last_x || last_y));
        if (!(lower || (upper && axis < 2)) || leaves) {
            refuse_mesh_part(place_of(slab, key) + ": is not on an edge of the slab");
        }
    }

    void weld_slice(std::size_t z) {
        const schema::SlabMesh* below = z > 0 ? slabs_[z - 1] : nullptr;
        const schema::SlabMesh* above = z < slabs_.size() ? slabs_[z] : nullptr;
        keys_.clear();
        first_ = first_key(z);
        end_ = first_key(z + 1);
        for (const schema::SlabMesh* slab : {below, above}) {
            if (slab == nullptr) continue;
            for (const std::uint64_t key : *slab->keys()) {
                if (slab == above) check_key(z, key);
                if (in_slice(key)) keys_.add(key - first_);
            }
        }
        base_ = mesh_.keys.size();
        const std::size_t count = keys_.count();
        mesh_.keys.resize(base_ + count);
        mesh_.p_grid.resize(base_ + count);
        mesh_.normals.resize(base_ + count);
        seen_.assign(count, 0);
        if (above != nullptr) {
            above_.resize(above->keys()->size());
            take_vertices(*above, z, seen_above, above_);
        }
        if (below != nullptr) {
            take_vertices(*below, z - 1, seen_below, below_);
        }
        if (below != nullptr && above != nullptr) {
            check_shared(z);
        }
    }

    bool in_slice(std::uint64_t key) const { return key >= first_ && key < end_; }

    /// vertex_of  Of each of the slab's vertices, the mesh's.
    void take_vertices(const schema::SlabMesh& slab, std::size_t slab_index, Seen seen,
                       std::vector<std::uint32_t>& vertex_of) {
        const auto& keys = *slab.keys();
        const auto& vertices = *slab.vertices();
        for (flatbuffers::uoffset_t i = 0; i < keys.size(); ++i) {
            const std::uint64_t key = keys[i];
            if (!in_slice(key)) continue;
            const std::uint32_t rank = keys_.rank(key - first_);
            if ((seen_[rank] & seen) != 0) {
                refuse_mesh_part(place_of(slab_index, key) + ": is there twice");
            }
            const schema::MeshVertex& v = *vertices[i];
            const std::size_t at = base_ + rank;
            if (seen_[rank] == 0) {
                mesh_.keys[at] = key;
                mesh_.p_grid[at] = {v.x(), v.y(), v.z()};
                mesh_.normals[at] = {v.nx(), v.ny(), v.nz()};
            } else {
                check_same(v, at, slab_index);
            }
            seen_[rank] = static_cast<std::uint8_t>(seen_[rank] | seen);
            vertex_of[i] = static_cast<std::uint32_t>(at);
        }
    }

    /// Throws unless slab `slab` and the one above it computed the same bits.
    void check_same(const schema::MeshVertex& v, std::size_t at, std::size_t slab) const {
        const glm::vec3 p(v.x(), v.y(), v.z()), n(v.nx(), v.ny(), v.nz());
        const glm::vec3 &q = mesh_.p_grid[at], &m = mesh_.normals[at];
        using glm::floatBitsToUint;
        if (floatBitsToUint(p) == floatBitsToUint(q) && floatBitsToUint(n) == floatBitsToUint(m)) {
            return;
        }
        refuse_mesh_part(
            fmt::format("{}: is at {} {} {} with normal {} {} {} here, at {} {} {} with {} {} {} "
                        "in slab {}",
                        place_of(slab, mesh_.keys[at]), p.x, p.y, p.z, n.x, n.y, n.z, q.x, q.y, q.z,
                        m.x, m.y, m.z, slab + 1));
    }

    /// Throws unless both slabs at slice z have all its vertices on edges within the slice.
    void check_shared(std::size_t z) const {
        for (std::size_t i = 0; i < seen_.size(); ++i) {
            const std::uint64_t key = mesh_.keys[base_ + i];
            if (key % 4 >= 2 || seen_[i] == (seen_above | seen_below)) continue;
            const bool here = seen_[i] == seen_above;
            refuse_mesh_part(fmt::format("{}: is not in slab {}, which shares it",
                                         place_of(here ? z : z - 1, key), here ? z - 1 : z));
        }
    }

    void append_triangles(std::size_t s) {
        const schema::SlabMesh& slab = *slabs_[s];
        const auto& indices = *slab.indices();
        const std::size_t count = indices.size() / 3;
        mesh_.slabs.push_back({static_cast<std::uint32_t>(s), mesh_.triangles.size(), count});
        for (flatbuffers::uoffset_t i = 0; i < 3 * count; i += 3) {
            mesh_.triangles.push_back(
                {below_[indices[i]], below_[indices[i + 1]], below_[indices[i + 2]]});
        }
        if (slab.origins() == nullptr) return;
        for (const schema::Origin* o : *slab.origins()) {
            mesh_.cells.push_back(
                {o->i(), o->j(), static_cast<std::uint16_t>(s), o->inside(), o->joined()});
        }
    }

    const VolumeGrid& grid_;
    const std::vector<const schema::SlabMesh*>& slabs_;
    SliceKeys keys_;
    WeldedMesh mesh_;
    std::uint64_t first_ = 0, end_ = 0;         ///< Keys of the slice under way.
    std::size_t base_ = 0;                      ///< Its first vertex.
    std::vector<std::uint8_t> seen_;            ///< One flag per vertex.
    std::vector<std::uint32_t> below_, above_;  ///< The mesh's vertices of the two slabs' there.
};

}  // namespace

MeshGather::MeshGather(VolumeGrid grid, std::uint16_t surface, std::uint32_t revision)
    : grid_(std::move(grid)), surface_(surface), revision_(revision), slabs_(grid_.slab_count()) {}

void MeshGather::add(const bus::Message& message) {
    const auto* part = message.as<schema::MeshPart>();
    assert(part != nullptr);
    if (part->surface() != surface_ || part->revision() != revision_) {
        refuse_mesh_part(
            fmt::format("mesh of surface {} revision {} from node {}, expected {} revision {}",
                        part->surface(), part->revision(), message.source(), surface_, revision_));
    }
    messages_.push_back(message);
    for (const schema::SlabMesh* slab : *part->slabs()) {
        if (slab->slab() >= slabs_.size()) {
            refuse_mesh_part(fmt::format("mesh of slab {} from node {}; the volume has {} slabs",
                                         slab->slab(), message.source(), slabs_.size()));
        }
        if (std::exchange(slabs_[slab->slab()], slab) != nullptr) {
            refuse_mesh_part(fmt::format("mesh of slab {} came twice, from node {} the second time",
                                         slab->slab(), message.source()));
        }
        if (slab->indices()->size() == 0) continue;  // Says nothing about origins.
        const bool origins = slab->origins() != nullptr;
        if (origins_.value_or(origins) != origins) {
            refuse_mesh_part(
                fmt::format("mesh of slab {} from node {} {} its triangles' cells, unlike others",
                            slab->slab(), message.source(), origins ? "tells" : "lacks"));
        }
        origins_ = origins;
    }
}

std::size_t MeshGather::missing() const {
    return static_cast<std::size_t>(std::count(slabs_.begin(), slabs_.end(), nullptr));
}

WeldedMesh MeshGather::finish(const Pause& pause) {
    const auto gap = std::find(slabs_.begin(), slabs_.end(), nullptr);
    if (gap != slabs_.end()) {
        refuse_mesh_part(fmt::format("mesh of slab {} is missing, of {} slabs {}",
                                     gap - slabs_.begin(), slabs_.size(), missing()));
    }
    WeldedMesh mesh = Weld(grid_, slabs_, origins_.value_or(false)).run(pause);
    slabs_.assign(slabs_.size(), nullptr);
    messages_.clear();
    return mesh;
}

}  // namespace pxpl5::host
