// Slice plane: a slice of the volume across one axis, as triangles whose corners have gray values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "gp_firmware/surface/mesh.hpp"
#include "gp_firmware/volume/slice_store.hpp"

namespace pxpl5::gp {

/// The voxels with one index along an axis.
struct SlicePlane {
    int axis = 2;                 ///< 0 x, 1 y, 2 z.
    int index = 0;                ///< Voxel along the axis, from 0.
    double black = 0, white = 1;  ///< Values that are drawn black and white; black < white.
    friend bool operator==(const SlicePlane&, const SlicePlane&) = default;
};

/// Returns an empty text if the volume has the plane, else what is wrong.
std::string plane_refusal(const SlicePlane& plane, const VolumeShape& shape);

/// Returns the number of the plane's triangles in a slab: two for each square of four voxels. A
/// plane across z belongs to the slab above, or to the top slab; the others cross every slab.
std::uint32_t plane_triangles(const SlicePlane& plane, const VolumeShape& shape, int slab);

/// Returns how many pieces the plane's part of a slab has. A piece has whole rows of squares, and
/// about 50,000 triangles at most, so that it takes a millisecond.
int plane_pieces(const SlicePlane& plane, const VolumeShape& shape, int slab);

/// The slice planes of one GP's slabs. Keeps the values of the planes that were drawn last, because
/// a compressed slice takes long to restore. They are working memory, and do not count as local
/// memory: a plane of 512 x 512 voxels takes 1 MiB.
class SlicePlanes {
  public:
    /// Returns the triangles of a piece. The mesh stays until the next call.
    ///
    /// A corner has its gray value in place of a normal: (0, 0, gray), and gray has 9 bits as
    /// isa::region::normal_unit counts them. Their upper 8 bits are the rounded gray value of 0 to
    /// 255. NaN is black. Positions are those of the voxels, so that neighboring pieces meet.
    ///
    /// store    A complete store that owns the slab (both are asserted).
    /// piece    0 .. plane_pieces() - 1 (asserted).
    /// origins  Fills in the voxel of each square, without a case (Origin::inside is 0).
    const SlabMesh& mesh(const SliceStore& store, const SlicePlane& plane, int slab, int piece,
                         bool origins);

  private:
    using Rows = std::map<int, std::vector<float>>;  ///< Values by slice.
    struct Values {
        int axis = 0, index = 0;
        Rows rows;
    };

    std::span<const float> row(const SliceStore& store, const SlicePlane& plane, int z);
    void add_corners(const SliceStore& store, const SlicePlane& plane, int slab, int down);
    void add_origins(const SlicePlane& plane, int across, int down);

    std::vector<Values> values_;  ///< The plane that was used last is at the end.
    SlabMesh mesh_;
};

}  // namespace pxpl5::gp
