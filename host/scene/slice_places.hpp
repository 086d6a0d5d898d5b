// Between slices as they are counted and where they lie in the grid, where they are unevenly
// spaced.
#pragma once

#include <span>

namespace pxpl5::host {

/// Grid z of slice `slice`, which may lie between two, or beyond the first or last: there the
/// spacing of the outermost two goes on.
///
/// places   As Volume::slice_places: ascending, at least 2; empty if slice z lies at z.
double place_of_slice(double slice, std::span<const double> places);

/// The inverse of place_of_slice().
double slice_of_place(double place, std::span<const double> places);

}  // namespace pxpl5::host
