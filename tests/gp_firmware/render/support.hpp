// Triangles on the screen's grid, what they cover by exact arithmetic, and streams taken apart.
#pragma once

#include <array>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "gp_firmware/geometry/bin.hpp"
#include "gp_firmware/render/draw_slab.hpp"
#include "gp_firmware/render/plane_setup.hpp"
#include "gp_firmware/render/triangle_program.hpp"
#include "isa/contract/triangle_shape.hpp"
#include "tests/random_seed.hpp"

namespace pxpl5::test {

namespace shape = isa::triangle;
using gp::ScreenVertex;
using Triangle = std::array<ScreenVertex, 3>;

/// The seed of the tests of drawing.
inline std::uint64_t seed() {
    return seed_or<std::uint64_t>(1);
}

class Random {
  public:
    explicit Random(std::uint64_t stream) : engine_(seed() * 1000003 + stream) {}
    /// Uniform in low..high, both included.
    int integer(int low, int high) { return std::uniform_int_distribution(low, high)(engine_); }
    double real(double low, double high) {
        return std::uniform_real_distribution(low, high)(engine_);
    }

  private:
    std::mt19937_64 engine_;
};

/// A vertex with random depth and normal at (x, y) in 1/16 px.
inline ScreenVertex vertex_at(int x, int y, Random& random) {
    constexpr int unit = isa::region::normal_unit;
    ScreenVertex v;
    v.x = x;
    v.y = y;
    v.z = random.integer(isa::region::z_margin, isa::region::z_far - isa::region::z_margin);
    v.nx = random.integer(-unit, unit);
    v.ny = random.integer(-unit, unit);
    v.nz = random.integer(-unit, unit);
    return v;
}

/// The triangle in positive orientation; nothing if its area is 0.
inline std::optional<Triangle> oriented(const Triangle& given) {
    Triangle t = given;
    const std::int64_t det = gp::determinant(t[0], t[1], t[2]);
    if (det == 0) {
        return std::nullopt;
    }
    if (det < 0) {
        std::swap(t[1], t[2]);
    }
    return t;
}

/// -1, 0 or 1: on which side of p -> q the point (x, y) / 16 lies, 1 to the right on the screen.
inline int side(const ScreenVertex& p, const ScreenVertex& q, std::int64_t x, std::int64_t y) {
    const std::int64_t cross = (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x);
    return cross > 0 ? 1 : cross < 0 ? -1 : 0;
}

/// Whether the center of pixel (px, py) belongs to a positively oriented triangle. The top-left
/// rule in its geometric form: a center on an edge belongs to where it comes to lie when all
/// centers move right by a hair, and down by a hair's hair.
inline bool covers(const Triangle& t, int px, int py) {
    const std::int64_t x = 16 * std::int64_t{px} + 8, y = 16 * std::int64_t{py} + 8;
    for (std::size_t k = 0; k < 3; ++k) {
        const ScreenVertex &p = t[k], &q = t[(k + 1) % 3];
        int where = side(p, q, x, y);
        if (where == 0) {
            // Moving right matters unless the edge is level.
            where = q.y != p.y ? (q.y < p.y ? 1 : -1) : (q.x > p.x ? 1 : -1);
        }
        if (where < 0) {
            return false;
        }
    }
    return true;
}

/// A signed plane or edge as instruction words have it.
struct Coefficients {
    std::int32_t a = 0, b = 0, c = 0;
    std::int64_t at(int x, int y) const { return std::int64_t{a} * x + std::int64_t{b} * y + c; }
};

inline Coefficients coefficients_at(const std::uint32_t* words, std::size_t at) {
    return {static_cast<std::int32_t>(words[at + 1]), static_cast<std::int32_t>(words[at + 2]),
            static_cast<std::int32_t>(words[at + 3])};
}

/// Whether TREEgeZERO of the edge word at `words[at]` leaves pixel (x, y) of the region enabled, by
/// the definition of its row: bit n - 1 of Q is 0.
inline bool edge_passes(const std::uint32_t* words, std::size_t at, int x, int y) {
    const std::uint32_t width = words[at] & 0xFF;
    return ((coefficients_at(words, at).at(x, y) >> (width - 1)) & 1) == 0;
}

inline bool triangle_passes(const std::uint32_t* words, int x, int y) {
    return edge_passes(words, shape::at_edge[0], x, y) &&
           edge_passes(words, shape::at_edge[1], x, y) &&
           edge_passes(words, shape::at_edge[2], x, y);
}

/// Orthographic, one voxel to the pixel: voxel (x, y, z) lands on grid (16 x, 16 y), exactly where
/// width and height are powers of two; z 0..1 spans the depth range, 0 in front.
inline gp::Camera pixel_camera(int width, int height) {
    gp::Camera camera;
    camera.width_px = width;
    camera.height_px = height;
    camera.projection = glm::dmat4(0.0);
    camera.projection[0][0] = 2.0 / width;
    camera.projection[1][1] = -2.0 / height;
    camera.projection[2][2] = 2.0;
    camera.projection[3] = glm::dvec4(-1.0, 1.0, -1.0, 1.0);
    return camera;
}

/// A mesh vertex that pixel_camera() puts at `v`, with v's normal.
inline gp::Vertex voxel_vertex(const ScreenVertex& v) {
    constexpr double depth = isa::region::z_far - 2.0 * isa::region::z_margin;
    const auto to_unit = [](std::int32_t n) {
        return static_cast<std::int16_t>(
            std::lround(n * static_cast<double>(gp::normal_one) / isa::region::normal_unit));
    };
    return {{static_cast<float>(v.x) / 16, static_cast<float>(v.y) / 16,
             static_cast<float>((v.z - static_cast<double>(isa::region::z_margin)) / depth)},
            {to_unit(v.nx), to_unit(v.ny), to_unit(v.nz)},
            0};
}

/// A slab of triangles that share no vertex.
inline gp::SlabMesh slab_of(std::span<const Triangle> triangles, int slab = 0) {
    gp::SlabMesh mesh;
    mesh.slab = slab;
    for (const Triangle& t : triangles) {
        for (const ScreenVertex& v : t) {
            mesh.indices.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
            mesh.vertices.push_back(voxel_vertex(v));
        }
    }
    return mesh;
}

/// A region's stream as it is sent.
inline std::vector<std::uint32_t> words_of(const gp::RegionPrograms& programs, std::size_t region,
                                           const gp::RegionGrid& grid) {
    std::vector<std::uint32_t> words(programs.regions()[region].word_count());
    gp::write_words(programs, region, grid, words.data());
    return words;
}

/// How often the streams' triangles cover each pixel of the picture, row by row.
inline std::vector<int> coverage(const gp::RegionPrograms& programs, const gp::RegionGrid& grid) {
    std::vector<int> counts(static_cast<std::size_t>(grid.width_px * grid.height_px), 0);
    for (int region = 0; region < grid.count(); ++region) {
        const auto words = words_of(programs, static_cast<std::size_t>(region), grid);
        const int x0 = region % grid.columns * 128, y0 = region / grid.columns * 128;
        for (std::size_t at = 0; at < words.size(); at += shape::word_count) {
            for (int y = y0; y < std::min(y0 + 128, grid.height_px); ++y) {
                for (int x = x0; x < std::min(x0 + 128, grid.width_px); ++x) {
                    counts[static_cast<std::size_t>(y * grid.width_px + x)] +=
                        triangle_passes(&words[at], x - x0, y - y0) ? 1 : 0;
                }
            }
        }
    }
    return counts;
}

}  // namespace pxpl5::test
