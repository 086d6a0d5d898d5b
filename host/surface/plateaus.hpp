// Where the choice of an isovalue matters little.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace pxpl5::host {

/// What extraction gives, or would give, at one isovalue.
struct IsovalueRow {
    double isovalue = 0;
    std::int64_t triangles = 0;
    double area_mm2 = 0, volume_mm3 = 0;
    std::int64_t components = 0;
};

/// Over how much of all rows' range of isovalues a plateau reaches at least.
inline constexpr double least_plateau_width = 0.04;
/// How much triangles and volume may change across a plateau of least width, as a fraction; as much
/// more across a wider one.
inline constexpr double greatest_plateau_change = 0.05;

/// A range of isovalues over which the surface stays about the same.
struct Plateau {
    std::string name;                 ///< "P1", "P2", ... by ascending isovalue.
    std::size_t first = 0, last = 0;  ///< Rows.
    double from = 0, to = 0;          ///< Isovalues.
    std::size_t flattest = 0;         ///< The row with the least change around it: one to try.
};

/// rows  Ascending by isovalue.
std::vector<Plateau> find_plateaus(std::span<const IsovalueRow> rows);

}  // namespace pxpl5::host
