#include "gp_firmware/surface/loop_triangulation.hpp"

#include <array>
#include <cassert>
#include <cstddef>

#include "gp_firmware/surface/case_tables.hpp"

namespace pxpl5::gp {

namespace {

constexpr int impossible = 1 << 20;  ///< More than the cost of any triangulation.

/// Returns twice the midpoint of an edge, which is an integer.
std::array<int, 3> doubled_midpoint(int edge) {
    const auto [a, b] = edge_corners(edge);
    return {(a & 1) + (b & 1), (a >> 1 & 1) + (b >> 1 & 1), (a >> 2 & 1) + (b >> 2 & 1)};
}

int diagonal_cost(int edge_a, int edge_b) {
    if (share_a_face(edge_a, edge_b)) {
        return impossible;
    }
    const auto a = doubled_midpoint(edge_a), b = doubled_midpoint(edge_b);
    int square = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        square += (a[i] - b[i]) * (a[i] - b[i]);
    }
    return square;
}

/// Computes the least costs of the polygons loop[i .. j], in the order of their lengths.
class CheapestTriangulation {
  public:
    explicit CheapestTriangulation(std::span<const std::uint8_t> loop) : loop_(loop) {
        for (std::size_t length = 2; length < loop.size(); ++length) {
            for (std::size_t i = 0; i + length < loop.size(); ++i) {
                solve(i, i + length);
            }
        }
    }

    bool possible() const { return cost_[0][loop_.size() - 1] < impossible; }

    void append(std::size_t i, std::size_t j, std::vector<std::uint8_t>& corners) const {
        if (j - i < 2) {
            return;
        }
        const std::size_t apex = apex_[i][j];
        append(i, apex, corners);
        corners.insert(corners.end(), {loop_[i], loop_[apex], loop_[j]});
        append(apex, j, corners);
    }

  private:
    int side_cost(std::size_t i, std::size_t j) const {
        return j - i == 1 ? 0 : diagonal_cost(loop_[i], loop_[j]);
    }

    void solve(std::size_t i, std::size_t j) {
        cost_[i][j] = impossible;
        for (std::size_t k = i + 1; k < j; ++k) {
            const int cost = cost_[i][k] + cost_[k][j] + side_cost(i, k) + side_cost(k, j);
            if (cost >= cost_[i][j]) {
                continue;
            }
            cost_[i][j] = cost;
            apex_[i][j] = k;
        }
    }

    std::span<const std::uint8_t> loop_;
    std::array<std::array<int, cell_edge_count>, cell_edge_count> cost_{};
    std::array<std::array<std::size_t, cell_edge_count>, cell_edge_count> apex_{};
};

}  // namespace

bool share_a_face(int edge_a, int edge_b) {
    // The corners of a face agree in one coordinate.
    const auto [a, b] = edge_corners(edge_a);
    const auto [c, d] = edge_corners(edge_b);
    return (a & b & c & d) != 0 || ((a | b | c | d) & 7) != 7;
}

std::vector<std::uint8_t> triangulate_loop(std::span<const std::uint8_t> loop) {
    assert(loop.size() >= 3);
    assert(loop.size() <= cell_edge_count);
    const CheapestTriangulation solution(loop);
    std::vector<std::uint8_t> corners;
    if (solution.possible()) {
        solution.append(0, loop.size() - 1, corners);
    }
    return corners;
}

std::vector<std::uint8_t> fan_about_center(std::span<const std::uint8_t> loop) {
    std::vector<std::uint8_t> corners;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        corners.insert(corners.end(), {loop[i], loop[(i + 1) % loop.size()], center_corner});
    }
    return corners;
}

}  // namespace pxpl5::gp
