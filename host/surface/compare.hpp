// Where two surfaces of one volume and isovalue differ: cells that two case tables treat otherwise.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "host/base/reply.hpp"
#include "host/surface/components.hpp"
#include "host/surface/welded_mesh.hpp"

namespace pxpl5::host {

/// Differing cells of one case.
struct CaseDifference {
    std::uint8_t inside = 0;  ///< Case: bit c is set if corner c of the cell is inside.
    std::size_t cells = 0;
};

struct MeshComparison {
    std::size_t cells = 0;            ///< Cells with triangles of either surface.
    std::size_t cells_differing = 0;  ///< Cells with triangles that differ by their vertices' keys.
    std::vector<CaseDifference> cases;      ///< Most cells first; of equals the lower case.
    Shown shown_a, shown_b;                 ///< Triangles in differing cells.
    std::int64_t holes_a = 0, holes_b = 0;  ///< Same as in Certificate.
};

/// Compares cell by cell; the order of a cell's triangles and of their corners does not matter.
/// Throws  RequestError if a mesh does not tell its triangles' cells, or not in ascending order;
///         and what `pause` throws.
MeshComparison compare_meshes(const WeldedMesh& a, const WeldedMesh& b, const VolumeGrid& grid,
                              const Pause& pause = {});

/// name_a, name_b  Of the surfaces.
Reply comparison_reply(const MeshComparison& comparison, std::string_view name_a,
                       std::string_view name_b);

}  // namespace pxpl5::host
