// From a loop of crossed cell edges to triangles.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace pxpl5::gp {

/// Triangulates a loop of cell edges so that no diagonal lies in a face of the cell. A diagonal in
/// a face could coincide with a diagonal of the neighbor cell; four triangles would share an edge.
///
/// Takes the triangulation with the shortest diagonals, measured between the edges' midpoints, and
/// among equals the first one in a fixed order.
/// loop     3 or more different edges.
/// Returns  Three edges per triangle, in the loop's sense; empty if there is no such triangulation.
std::vector<std::uint8_t> triangulate_loop(std::span<const std::uint8_t> loop);

/// Returns triangles from each side of the loop to the cell's center vertex.
std::vector<std::uint8_t> fan_about_center(std::span<const std::uint8_t> loop);

/// Returns whether both edges bound one face of the cell.
bool share_a_face(int edge_a, int edge_b);

}  // namespace pxpl5::gp
