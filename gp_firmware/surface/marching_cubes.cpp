#include "gp_firmware/surface/marching_cubes.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>

#include "gp_firmware/surface/border.hpp"
#include "gp_firmware/surface/measure.hpp"
#include "gp_firmware/surface/slab_walk.hpp"

namespace pxpl5::gp {

namespace {

/// More than any slab has.
constexpr std::size_t all_triangles = std::numeric_limits<std::uint32_t>::max();

/// Returns whether the ranges of the slices show that the surface crosses no cell of the slab.
bool is_empty(const SliceStore& store, int slab, double isovalue) {
    const RowSide lower = side_of(store.slice(slab).rows.slice, isovalue);
    const RowSide upper = side_of(store.slice(slab + 1).rows.slice, isovalue);
    return lower == upper && lower != RowSide::mixed;
}

SlabExtraction begin_walk(const SliceStore& store, int slab, double isovalue,
                          const CaseTable& table, SlabMesh& out, Wanted wanted,
                          VectorTarget target) {
    if (!std::isfinite(isovalue)) {
        throw std::invalid_argument("an isovalue is a finite number, not " +
                                    std::to_string(isovalue));
    }
    assert(store.complete());
    assert(std::binary_search(store.slabs().begin(), store.slabs().end(), slab));
    out.slab = slab;
    out.counts = {};
    const auto finish = [&store, slab, isovalue, decides_faces = table.decides_faces, &out,
                         target](std::size_t) {
        measure(store.shape(), inside_of_last_face(store, slab, isovalue, decides_faces), out,
                target);
        return false;
    };
    SlabExtraction extraction = finish;
    if (is_empty(store, slab, isovalue)) {
        out.counts.rows_skipped = static_cast<std::uint32_t>(store.shape().ny - 1);
        out.vertices.clear();
        out.keys.clear();
        out.indices.clear();
        out.origins.clear();
    } else {
        with_scalar(store.shape().type, [&]<class T>(T) {
            auto walk =
                std::make_shared<SlabWalk<T>>(store, slab, isovalue, table, out, wanted, target);
            extraction = [walk, finish](std::size_t triangles) {
                return walk->advance(triangles) || finish(0);
            };
        });
    }
    return extraction;
}

void walk_slab(const SliceStore& store, int slab, double isovalue, const CaseTable& table,
               SlabMesh& out, Wanted wanted, VectorTarget target) {
    const SlabExtraction extraction = begin_walk(store, slab, isovalue, table, out, wanted, target);
    while (extraction(all_triangles)) {
    }
}

}  // namespace

void extract_slab(const SliceStore& store, int slab, double isovalue, const CaseTable& table,
                  SlabMesh& out, bool origins, VectorTarget target) {
    walk_slab(store, slab, isovalue, table, out, origins ? Wanted::mesh_with_origins : Wanted::mesh,
              target);
}

SlabExtraction begin_slab(const SliceStore& store, int slab, double isovalue,
                          const CaseTable& table, SlabMesh& out, bool origins) {
    return begin_walk(store, slab, isovalue, table, out,
                      origins ? Wanted::mesh_with_origins : Wanted::mesh, isa::process_target());
}

SlabCounts measure_slab(const SliceStore& store, int slab, double isovalue, const CaseTable& table,
                        SlabMesh& scratch) {
    walk_slab(store, slab, isovalue, table, scratch, Wanted::measures, isa::process_target());
    return scratch.counts;
}

std::size_t size_bytes(const SlabMesh& mesh) {
    return mesh.vertices.capacity() * sizeof(Vertex) +
           mesh.keys.capacity() * sizeof(std::uint64_t) +
           mesh.indices.capacity() * sizeof(std::uint32_t) +
           mesh.spheres.capacity() * sizeof(Sphere) + mesh.lines.capacity() * sizeof(Line);
}

}  // namespace pxpl5::gp
