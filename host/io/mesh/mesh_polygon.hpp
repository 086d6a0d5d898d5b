// Polygons of mesh files as triangles, and numbers of their texts.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "host/io/mesh/mesh_read.hpp"

namespace pxpl5::host::io {

/// Adds the triangles of a polygon: a fan of a convex polygon, the ears of a concave one.
/// corners  Indices of `out.points`; fewer than three add nothing.
void add_polygon(MeshFile& out, std::span<const std::uint32_t> corners);

/// The whole word as a number. Throws MeshError with `where` for other words, nan and infinity.
double number_of(const std::string& where, std::string_view word);

}  // namespace pxpl5::host::io
