#include "host/surface/isovalue_components.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>
#include <type_traits>

#include "host/error.hpp"
#include "host/surface/typed_values.hpp"

namespace pxpl5::host {

namespace {

/// A voxel's level is the number of isovalues that it is inside of: those with a lower index.
using Level = std::uint16_t;
constexpr std::size_t max_isovalues = std::numeric_limits<Level>::max() - 1;
constexpr std::size_t max_voxels = std::numeric_limits<std::uint32_t>::max();

Level level_of(double value, std::span<const double> isovalues) {
    if (std::isnan(value)) return 0;
    return static_cast<Level>(std::upper_bound(isovalues.begin(), isovalues.end(), value) -
                              isovalues.begin());
}

/// Levels of all voxels, with one voxel more on every side.
struct LevelGrid {
    std::size_t nx = 0, ny = 0, nz = 0;  ///< Without the rim.
    std::ptrdiff_t row = 0, slice = 0;   ///< Steps along y and z, with the rim.
    std::vector<Level> levels;

    std::size_t first_of_row(std::size_t y, std::size_t z) const {
        return (z + 1) * static_cast<std::size_t>(slice) + (y + 1) * static_cast<std::size_t>(row) +
               1;
    }

    /// Gives all voxels of the rim one level.
    void fill_rim(Level level) {
        const auto width = static_cast<std::size_t>(row);
        const std::size_t rows = levels.size() / width, rows_of_slice = ny + 2;
        for (std::size_t r = 0; r < rows; ++r) {
            const std::size_t y = r % rows_of_slice, z = r / rows_of_slice;
            const bool whole = y == 0 || y > ny || z == 0 || z > nz;
            Level* const at = levels.data() + r * width;
            if (whole) {
                std::fill_n(at, width, level);
            } else {
                at[0] = at[width - 1] = level;
            }
        }
    }
};

template <class T>
void fill_levels(std::span<const T> values, std::span<const double> isovalues, LevelGrid& grid) {
    std::vector<Level> of_value;  // Of whole numbers: a table is faster than a search.
    if constexpr (std::is_integral_v<T>) {
        of_value.resize(std::size_t{1} << (8 * sizeof(T)));
        for (std::size_t i = 0; i < of_value.size(); ++i)
            of_value[i] = level_of(static_cast<double>(static_cast<T>(i)), isovalues);
    }
    const T* value = values.data();
    for (std::size_t z = 0; z < grid.nz; ++z)
        for (std::size_t y = 0; y < grid.ny; ++y) {
            Level* const to = grid.levels.data() + grid.first_of_row(y, z);
            for (std::size_t x = 0; x < grid.nx; ++x, ++value) {
                if constexpr (std::is_integral_v<T>) {
                    to[x] = of_value[static_cast<std::make_unsigned_t<T>>(*value)];
                } else {
                    to[x] = level_of(static_cast<double>(*value), isovalues);
                }
            }
        }
}

LevelGrid level_grid(const Volume& volume, std::span<const double> isovalues) {
    LevelGrid grid;
    grid.nx = static_cast<std::size_t>(volume.nx);
    grid.ny = static_cast<std::size_t>(volume.ny);
    grid.nz = static_cast<std::size_t>(volume.nz);
    const std::size_t count = (grid.nx + 2) * (grid.ny + 2) * (grid.nz + 2);
    if (count > max_voxels) {
        throw RequestError(ExitCode::failed,
                           fmt::format("counting components: {}x{}x{} voxels with a rim are {}, "
                                       "more than {}",
                                       volume.nx, volume.ny, volume.nz, count, max_voxels));
    }
    grid.row = volume.nx + 2;
    grid.slice = grid.row * (volume.ny + 2);
    grid.levels.resize(count);
    with_values(volume, [&]<class T>(std::span<const T> values) {
        assert(values.size() == grid.nx * grid.ny * grid.nz);
        fill_levels(values, isovalues, grid);
    });
    return grid;
}

/// Groups of voxels that grow level by level. A voxel that has come links to another of its group;
/// one that has not, to the next of its level.
class LevelGroups {
  public:
    LevelGroups(const LevelGrid& grid, std::size_t level_count)
        : links_(grid.levels.size()), heads_(level_count, end) {
        // Backwards, so that each level's voxels ascend.
        for (std::size_t z = grid.nz; z-- > 0;)
            for (std::size_t y = grid.ny; y-- > 0;) {
                const std::size_t first = grid.first_of_row(y, z);
                for (std::size_t v = first + grid.nx; v-- > first;) {
                    std::uint32_t& head = heads_[grid.levels[v]];
                    links_[v] = head;
                    head = static_cast<std::uint32_t>(v);
                }
            }
    }

    /// Lets a level's voxels come, in ascending order; calls visit(voxel) after each.
    template <class Visit>
    void add_level(std::size_t level, Visit visit) {
        for (std::uint32_t v = heads_[level]; v != end;) {
            const std::uint32_t next = links_[v];
            links_[v] = v;
            ++count_;
            visit(v);
            v = next;
        }
    }

    /// Both have come.
    void join(std::uint32_t a, std::uint32_t b) {
        a = root(a);
        b = root(b);
        if (a == b) return;
        links_[std::max(a, b)] = std::min(a, b);
        --count_;
    }
    std::uint32_t count() const { return count_; }

  private:
    static constexpr std::uint32_t end = 0;  ///< A voxel of the rim, which never comes.

    std::uint32_t root(std::uint32_t v) {
        while (links_[v] != v) v = links_[v] = links_[links_[v]];
        return v;
    }

    std::vector<std::uint32_t> links_;
    std::vector<std::uint32_t> heads_;  ///< First voxel of each level.
    std::uint32_t count_ = 0;
};

void count_inside(LevelGrid& grid, std::span<ComponentCounts> out) {
    grid.fill_rim(0);  // Never inside.
    LevelGroups groups(grid, out.size() + 1);
    const std::array<std::ptrdiff_t, 3> steps = {1, grid.row, grid.slice};
    for (std::size_t level = out.size(); level > 0; --level) {
        groups.add_level(level, [&](std::uint32_t v) {
            const Level* const at = grid.levels.data() + v;
            for (const std::ptrdiff_t step : steps) {
                // Of its own level, the lower neighbours have come.
                if (at[-step] >= level) groups.join(v, static_cast<std::uint32_t>(v - step));
                if (at[step] > level) groups.join(v, static_cast<std::uint32_t>(v + step));
            }
        });
        out[level - 1].inside = groups.count();
    }
}

/// A step to a neighbour across a face's diagonal, and the two steps that make it up.
struct Diagonal {
    std::ptrdiff_t step, along, across;
};

void count_outside(LevelGrid& grid, std::span<ComponentCounts> out) {
    grid.fill_rim(std::numeric_limits<Level>::max());  // Never outside.
    LevelGroups groups(grid, out.size() + 1);
    const std::array<std::ptrdiff_t, 3> steps = {1, grid.row, grid.slice};
    std::array<Diagonal, 6> diagonals{};
    std::size_t count = 0;
    for (const auto& [a, b] :
         {std::pair{steps[0], steps[1]}, {steps[0], steps[2]}, {steps[1], steps[2]}}) {
        diagonals[count++] = {a + b, a, b};
        diagonals[count++] = {b - a, -a, b};
    }
    for (std::size_t level = 0; level < out.size(); ++level) {
        groups.add_level(level, [&](std::uint32_t v) {
            const Level* const at = grid.levels.data() + v;
            for (const std::ptrdiff_t step : steps) {
                if (at[-step] <= level) groups.join(v, static_cast<std::uint32_t>(v - step));
                if (at[step] < level) groups.join(v, static_cast<std::uint32_t>(v + step));
            }
            // Only an ambiguous face, with both others inside, joins what edges do not.
            for (const auto& [step, along, across] : diagonals) {
                if (at[-step] <= level && at[-along] > level && at[-across] > level)
                    groups.join(v, static_cast<std::uint32_t>(v - step));
                if (at[step] < level && at[along] > level && at[across] > level)
                    groups.join(v, static_cast<std::uint32_t>(v + step));
            }
        });
        out[level].outside = groups.count();
    }
}

}  // namespace

std::vector<ComponentCounts> count_components(const Volume& volume,
                                              std::span<const double> isovalues) {
    assert(std::is_sorted(isovalues.begin(), isovalues.end()));
    assert(isovalues.size() <= max_isovalues);
    std::vector<ComponentCounts> out(isovalues.size());
    if (out.empty()) return out;
    LevelGrid grid = level_grid(volume, isovalues);
    count_inside(grid, out);
    count_outside(grid, out);
    return out;
}

}  // namespace pxpl5::host
