#include "host/serve/depths/lean_cells.hpp"

#include "host/serve/depths/depth_word.hpp"

namespace pxpl5::host::serve {
namespace {

constexpr std::size_t side = lean_cell_px;
constexpr std::size_t block_px = 32;  ///< Width of a row of cells that are tested together.

/// Whether one of the pixels shows a surface.
bool any_shows_surface(std::span<const std::uint32_t, block_px> words) {
    std::uint32_t all = 0;
    for (const std::uint32_t word : words) {
        all |= word;
    }
    return shows_surface(all);
}

/// Adds a row of pixels of a cell. Returns a bit per pixel that shows a surface, the left lowest.
template <std::size_t Count>
unsigned add_row(DepthRange& range, std::span<const std::uint32_t, Count> words) {
    unsigned bits = 0;
    for (std::size_t x = 0; x < words.size(); ++x) {
        const bool shows = shows_surface(words[x]);
        const std::uint32_t depth = depth_of(words[x]);
        range.nearest = std::min(range.nearest, shows ? depth : no_depth);
        range.farthest = std::max(range.farthest, shows ? depth : 0);
        bits |= (shows ? 1U : 0U) << x;
    }
    return bits;
}

/// Finds the covered cells of one row of cells.
class CellRow {
  public:
    CellRow(LeanDepths& lean, std::span<const std::uint32_t> depths, std::size_t row)
        : width_(static_cast<std::size_t>(lean.width)),
          down_(std::min(side, static_cast<std::size_t>(lean.height) - row * side)),
          row_bytes_(mask_row_bytes(lean.width)),
          words_(depths.subspan(row * side * width_, down_ * width_)),
          mask_(std::span(lean.mask).subspan(row * side * row_bytes_, down_ * row_bytes_)),
          row_(row) {}

    void find(std::vector<CoveredCell>& covered) {
        for (std::size_t x = 0; x < width_; x += block_px) {
            if (x + block_px > width_ || shows_block(x)) {
                find_in(x, std::min(x + block_px, width_), covered);
            }
        }
    }

  private:
    bool shows_block(std::size_t x) const {
        bool shows = false;
        for (std::size_t y = 0; y < down_ && !shows; ++y) {
            shows = any_shows_surface(words_.subspan(y * width_ + x).first<block_px>());
        }
        return shows;
    }
    void find_in(std::size_t x, std::size_t end, std::vector<CoveredCell>& covered) {
        for (; x < end; x += side) {
            const DepthRange range = x + side <= end ? add_cell<side>(x, side)
                                                     : add_cell<std::dynamic_extent>(x, end - x);
            if (range.nearest != no_depth) {
                const std::size_t cell = row_ * ((width_ + side - 1) / side) + x / side;
                covered.push_back({static_cast<std::uint32_t>(cell),
                                   static_cast<std::uint32_t>(cell + row_), range});
            }
        }
    }
    template <std::size_t Count>
    DepthRange add_cell(std::size_t x, std::size_t across) {
        DepthRange range;
        for (std::size_t y = 0; y < down_; ++y) {
            const std::span<const std::uint32_t, Count> words(&words_[y * width_ + x], across);
            std::uint8_t& mask = mask_[y * row_bytes_ + x / 8];
            mask = static_cast<std::uint8_t>(mask | add_row(range, words) << (x % 8));
        }
        return range;
    }

    std::size_t width_, down_, row_bytes_;
    std::span<const std::uint32_t> words_;
    std::span<std::uint8_t> mask_;
    std::size_t row_;
};

}  // namespace

std::vector<CoveredCell> find_covered(LeanDepths& lean, std::span<const std::uint32_t> depths) {
    std::vector<CoveredCell> covered;
    for (std::size_t row = 0; row + 1 < static_cast<std::size_t>(lean.rows); ++row) {
        CellRow(lean, depths, row).find(covered);
    }
    return covered;
}

}  // namespace pxpl5::host::serve
