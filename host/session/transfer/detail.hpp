// Detail: when surfaces can be simplified, and how much a moving picture needs it.
#pragma once

#include <cstdint>
#include <string>

#include "host/scene/scene.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host {

/// Triangles of a moving picture with `detail auto`. A core of 2020 draws so many in about 0.1 s.
inline constexpr std::int64_t moving_triangles = 2'000'000;

/// Returns why surfaces of the volume cannot be simplified on `gp_count` GPs, with the remedy;
/// empty if they can.
std::string simplification_refusal(const Volume& volume, int gp_count);

/// Returns the least detail number that leaves at most `most` of `triangles` exact triangles, or
/// max_detail. Cells with a side of n voxels are assumed to leave one of n * n triangles.
int moving_detail(std::int64_t triangles, std::int64_t most = moving_triangles);

/// Returns a bound of distances in mm as "7.114", rounded up, because it must stay a bound.
std::string bound_text(double mm);

/// Returns the word for the command `detail`: "exact", "auto", "1", ...
std::string detail_word(const DetailChoice& choice);

}  // namespace pxpl5::host
