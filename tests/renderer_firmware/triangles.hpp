// Random triangle programs (isa/contract/triangle_shape.hpp) of every kind, for tests.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <vector>

#include "isa/contract/triangle_shape.hpp"
#include "tests/isa/random_program.hpp"

namespace pxpl5::test {

struct Corner {
    std::int32_t x = 0, y = 0;  ///< In 1/16 pixel.
};

/// The planes of one triangle, in the order of its program.
struct TrianglePlanes {
    std::int32_t edges[3][3]{};
    std::int32_t z[3]{};
    std::int32_t normals[3][3]{};
    std::uint32_t surface = 1;
    std::uint32_t widths[3]{};  ///< Widths of the edges' sign tests; 0: the narrowest that fits.
};

/// The half plane left of p -> q (y downward), with Q in 1/16 pixel: floor(C16 / 16), with the bias
/// of the top-left rule.
inline void put_edge(Corner p, Corner q, std::int32_t* edge) {
    const std::int64_t a = p.y - q.y, b = q.x - p.x;
    const std::int64_t c = -(a * p.x + b * p.y);
    const bool top_left = a > 0 || (a == 0 && b > 0);
    edge[0] = static_cast<std::int32_t>(a);
    edge[1] = static_cast<std::int32_t>(b);
    edge[2] = static_cast<std::int32_t>((c - (top_left ? 0 : 1)) >> 4);
}

/// Returns the three edges of a triangle, oriented so that the inside is positive.
inline void put_edges(Corner p, Corner q, Corner r, TrianglePlanes& planes) {
    const std::int64_t twice_area =
        std::int64_t{q.x - p.x} * (r.y - p.y) - std::int64_t{r.x - p.x} * (q.y - p.y);
    if (twice_area < 0) {
        std::swap(q, r);
    }
    put_edge(p, q, planes.edges[0]);
    put_edge(q, r, planes.edges[1]);
    put_edge(r, p, planes.edges[2]);
}

/// Returns the narrowest width that holds Q in the whole region.
inline std::uint32_t edge_width(const std::int32_t* e) {
    const std::int64_t most = (std::llabs(e[0]) + std::llabs(e[1])) * 127 + std::llabs(e[2]);
    for (const std::uint32_t n : isa::triangle::edge_widths) {
        if (most < std::int64_t{1} << (n - 1)) {
            return n;
        }
    }
    return 32;
}

inline void append(const TrianglePlanes& t, std::vector<std::uint32_t>& words) {
    const auto put = [&words](std::uint32_t word, const std::int32_t* k) {
        words.push_back(word);
        for (int i = 0; i < 3; ++i) {
            words.push_back(static_cast<std::uint32_t>(k[i]));
        }
    };
    words.push_back(isa::triangle::enable_word);
    for (int k = 0; k < 3; ++k) {
        const std::uint32_t width = t.widths[k] == 0 ? edge_width(t.edges[k]) : t.widths[k];
        put(isa::triangle::edge_word(width), t.edges[k]);
    }
    put(isa::triangle::z_test_word, t.z);
    put(isa::triangle::z_store_word, t.z);
    for (std::size_t k = 0; k < 3; ++k) {
        put(isa::triangle::normal_words[k], t.normals[k]);
    }
    words.push_back(isa::triangle::surface_word(t.surface));
}

/// Returns a triangle around (x, y) (1/16 pixel) with corners within `reach`. There are about 16
/// depths, so that ties are frequent.
inline TrianglePlanes random_triangle(RandomPrograms& random, Corner center, std::int32_t reach) {
    const auto corner = [&] {
        const auto offset = [&] {
            return static_cast<std::int32_t>(
                       random.below(static_cast<std::uint32_t>(2 * reach + 1))) -
                   reach;
        };
        return Corner{center.x + offset(), center.y + offset()};
    };
    TrianglePlanes t;
    put_edges(corner(), corner(), corner(), t);
    const bool flat = random.below(2) == 0;
    t.z[0] = flat ? 0 : random.coefficient() % 100'000;
    t.z[1] = flat ? 0 : random.coefficient() % 100'000;
    t.z[2] = static_cast<std::int32_t>((1 + random.below(15)) << 28);
    for (auto& normal : t.normals) {
        for (std::int32_t& k : normal) {
            k = random.coefficient();
        }
    }
    t.surface = 1 + random.below(255);
    return t;
}

/// Returns triangles of all sizes, many of them across the edge of the region.
inline void append_random_triangles(RandomPrograms& random, std::size_t count,
                                    std::vector<std::uint32_t>& words) {
    constexpr std::int32_t reaches[] = {8, 24, 48, 160, 1000, 4000, 200'000};
    for (std::size_t i = 0; i < count; ++i) {
        const std::int32_t reach = reaches[random.below(7)];
        const auto x = static_cast<std::int32_t>(random.below(2200)) - 80;
        const auto y = static_cast<std::int32_t>(random.below(2200)) - 80;
        append(random_triangle(random, {x, y}, reach), words);
    }
}

}  // namespace pxpl5::test
