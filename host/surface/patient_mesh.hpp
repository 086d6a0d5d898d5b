// Surfaces in patient millimeters, as files contain them: without the grid of a volume.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "host/surface/volume_grid.hpp"
#include "host/surface/welded_mesh.hpp"

namespace pxpl5::host {

/// Share of the distance between two voxels that vertices of an exported surface keep from both.
inline constexpr double least_from_voxel = 1.0 / 1024;

/// Moves vertices that lie at a voxel by least_from_voxel along their edge. If the isovalue is the
/// value of a voxel, up to six vertices lie there, and files without keys would join them.
void keep_apart(WeldedMesh& mesh, const VolumeGrid& grid);

/// The surface in millimeters. Its keys become numbers, and its cells go.
void move_to_patient(WeldedMesh& mesh, const VolumeGrid& grid);

/// The grid of surfaces in millimeters: it has no voxels and no border.
VolumeGrid patient_grid();

/// A surface of a file, in which each place has one vertex.
struct WeldedFile {
    WeldedMesh mesh;
    std::int64_t collapsed = 0;  ///< Triangles with two corners at one place, which are left out.
};

/// Vertices that no triangle has are left out, too.
/// triangles  Indices of `points_mm`.
WeldedFile weld(std::span<const glm::vec3> points_mm,
                std::span<const std::array<std::uint32_t, 3>> triangles);

}  // namespace pxpl5::host
