#include "host/surface/atlas/isovalue_components.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <type_traits>

#include "host/base/error.hpp"
#include "host/surface/atlas/neighbor_links.hpp"
#include "host/volume/typed_values.hpp"

namespace pxpl5::host {

namespace {

/// A voxel's level is the number of isovalues that it is inside of: those with a lower index.
using Level = std::uint16_t;
constexpr std::size_t max_levels = std::numeric_limits<Level>::max() - 1;
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
    std::vector<Level> of_value;  // For whole numbers, a table is faster than a search.
    if constexpr (std::is_integral_v<T>) {
        of_value.resize(std::size_t{1} << (8 * sizeof(T)));
        for (std::size_t i = 0; i < of_value.size(); ++i)
            of_value[i] = level_of(static_cast<double>(static_cast<T>(i)), isovalues);
    }
    const T* value = values.data();
    for (std::size_t z = 0; z < grid.nz; ++z) {
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

/// In the order of the sweep inwards the highest levels come first, outwards the lowest; of equal
/// ones the lower voxel. A voxel's links are its neighbors that came before it.
template <Side side>
class Sweep {
  public:
    /// grid  Its rim is overwritten.
    Sweep(LevelGrid& grid, std::size_t isovalue_count)
        : grid_(grid),
          never_(static_cast<Level>(side == Side::inside ? 0 : isovalue_count)),
          groups_(isovalue_count + 1),
          saddle_counts_(isovalue_count + 1),
          parents_(grid.levels.size()),
          is_saddle_((grid.levels.size() + 63) / 64) {
        grid.fill_rim(side == Side::inside ? 0 : std::numeric_limits<Level>::max());
        for (std::size_t k = 0; k < neighbor_count; ++k) {
            const auto& [x, y, z] = neighbor_steps()[k];
            steps_[k] = x + y * grid.row + z * grid.slice;
        }
        std::iota(parents_.begin(), parents_.end(), std::uint32_t{0});
    }

    /// Groups that begin with a voxel of each level, less those that are joined by one.
    const std::vector<std::int64_t>& run() {
        for (std::size_t z = 0; z < grid_.nz; ++z)
            for (std::size_t y = 0; y < grid_.ny; ++y) join_row(grid_.first_of_row(y, z));
        join_saddles();
        return groups_;
    }

  private:
    static bool is_before(Level other, Level level, bool is_lower_voxel) {
        if constexpr (side == Side::inside) {
            return is_lower_voxel ? other >= level : other > level;
        } else {
            return is_lower_voxel ? other <= level : other < level;
        }
    }

    std::uint32_t links_of(std::uint32_t v) const {
        const Level* const at = grid_.levels.data() + v;
        std::uint32_t links = 0;
        for (std::size_t k = 0; k < neighbor_count; ++k)
            links |= is_before(at[steps_[k]], at[0], steps_[k] < 0) ? 1U << k : 0U;
        return links;
    }

    /// Where all links of a voxel hang together around it, one of them joins it to them all: it
    /// need not wait for its turn. The others are saddles.
    void join_row(std::size_t first) {
        const Level* const at = grid_.levels.data() + first;
        links_.assign(grid_.nx, 0);
        for (std::size_t k = 0; k < neighbor_count; ++k) {
            const Level* const other = at + steps_[k];
            const bool is_lower_voxel = steps_[k] < 0;
            for (std::size_t x = 0; x < grid_.nx; ++x) {
                links_[x] |= static_cast<std::uint32_t>(is_before(other[x], at[x], is_lower_voxel))
                             << k;
            }
        }
        const LinkTable& hangs_together = link_table(side);
        for (std::size_t x = 0; x < grid_.nx; ++x) {
            if (at[x] == never_) continue;
            ++groups_[at[x]];
            const std::uint32_t links = links_[x] & joining_links(side);
            if (links == 0) continue;
            const auto v = static_cast<std::uint32_t>(first + x);
            if (hangs_together.test(links_[x])) {
                join(v, std::countr_zero(links));
            } else {
                is_saddle_[v / 64] |= std::uint64_t{1} << v % 64;
                ++saddle_counts_[at[x]];
            }
        }
    }

    /// In the order of their levels, as Kruskal's algorithm takes edges.
    void join_saddles() {
        std::vector<std::size_t> next(saddle_counts_.size());
        std::size_t sum = 0;
        for (std::size_t i = 0; i < next.size(); ++i) {
            const std::size_t level = side == Side::inside ? next.size() - 1 - i : i;
            next[level] = sum;
            sum += saddle_counts_[level];
        }
        std::vector<std::uint32_t> saddles(sum);
        for (std::size_t word = 0; word < is_saddle_.size(); ++word) {
            for (std::uint64_t bits = is_saddle_[word]; bits != 0; bits &= bits - 1) {
                const auto v =
                    static_cast<std::uint32_t>(word * 64) + std::uint32_t(std::countr_zero(bits));
                saddles[next[grid_.levels[v]]++] = v;
            }
        }
        for (const std::uint32_t v : saddles) {
            for (std::uint32_t links = links_of(v) & joining_links(side); links != 0;
                 links &= links - 1) {
                join(v, std::countr_zero(links));
            }
        }
    }

    void join(std::uint32_t v, int neighbor) {
        const std::uint32_t a = root(v);
        const std::uint32_t b =
            root(static_cast<std::uint32_t>(v + steps_[static_cast<std::size_t>(neighbor)]));
        if (a == b) return;
        parents_[std::max(a, b)] = std::min(a, b);
        --groups_[grid_.levels[v]];
    }

    std::uint32_t root(std::uint32_t v) {
        while (parents_[v] != v) v = parents_[v] = parents_[parents_[v]];
        return v;
    }

    const LevelGrid& grid_;
    Level never_;  ///< Level of voxels that this sweep never counts.
    std::array<std::ptrdiff_t, neighbor_count> steps_{};
    std::vector<std::int64_t> groups_;  ///< By level.
    std::vector<std::size_t> saddle_counts_;
    std::vector<std::uint32_t> parents_;
    std::vector<std::uint64_t> is_saddle_;
    std::vector<std::uint32_t> links_;  ///< Links of a row's voxels; bit k: neighbor k.
};

void count_inside(LevelGrid& grid, std::span<ComponentCounts> out) {
    const auto groups = Sweep<Side::inside>(grid, out.size()).run();
    std::int64_t sum = 0;
    for (std::size_t i = out.size(); i-- > 0;) {
        sum += groups[i + 1];
        out[i].inside = static_cast<std::uint32_t>(sum);
    }
}

void count_outside(LevelGrid& grid, std::span<ComponentCounts> out) {
    const auto groups = Sweep<Side::outside>(grid, out.size()).run();
    std::int64_t sum = 0;
    for (std::size_t i = 0; i < out.size(); ++i) {
        sum += groups[i];
        out[i].outside = static_cast<std::uint32_t>(sum);
    }
}

}  // namespace

std::vector<ComponentCounts> count_components(const Volume& volume,
                                              std::span<const double> isovalues) {
    assert(std::is_sorted(isovalues.begin(), isovalues.end()));
    assert(isovalues.size() <= max_levels);
    if (std::min({volume.nx, volume.ny, volume.nz}) < 2) {
        throw RequestError(ExitCode::failed,
                           fmt::format("counting components: {}x{}x{} voxels have no cell, which "
                                       "takes 2 along each axis",
                                       volume.nx, volume.ny, volume.nz));
    }
    std::vector<ComponentCounts> out(isovalues.size());
    if (out.empty()) return out;
    LevelGrid grid = level_grid(volume, isovalues);
    count_inside(grid, out);
    count_outside(grid, out);
    return out;
}

}  // namespace pxpl5::host
