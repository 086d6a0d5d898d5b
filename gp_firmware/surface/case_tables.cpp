#include "gp_firmware/surface/case_tables.hpp"

#include <bit>
#include <cassert>
#include <limits>
#include <utility>

#include "gp_firmware/surface/loop_triangulation.hpp"

namespace pxpl5::gp {

namespace {

using Loop = std::vector<std::uint8_t>;  ///< Edges, in the order of the surface's boundary.

bool is_inside(unsigned inside, int corner) {
    return (inside >> corner & 1) != 0;
}

int edge_between(int a, int b) {
    const int low = a & b;
    switch (a ^ b) {
        case 1:
            return (low >> 1 & 1) | (low >> 2 & 1) << 1;
        case 2:
            return 4 + ((low & 1) | (low >> 2 & 1) << 1);
        default:
            return 8 + ((low & 1) | (low >> 1 & 1) << 1);
    }
}

bool is_ambiguous(unsigned inside, int face) {
    const auto [a, b, c, d] = face_corners(face);
    return is_inside(inside, a) == is_inside(inside, c) &&
           is_inside(inside, b) == is_inside(inside, d) &&
           is_inside(inside, a) != is_inside(inside, b);
}

/// next[e] = f: on some face, the surface's boundary runs from the crossing of edge e to the
/// crossing of edge f. -1 if edge e is not crossed.
using Successors = std::array<int, cell_edge_count>;

/// A counter-clockwise walk around a face enters a stretch of inside corners on one edge and leaves
/// it on another. The surface's boundary runs from the first edge to the second, so that the loops
/// are counter-clockwise seen from outside. If inside corners are joined, the boundary cuts off
/// stretches of outside corners instead, and starts where the stretch ends.
void trace_face(unsigned inside, int face, bool joined, Successors& next) {
    const auto corner = face_corners(face);
    const auto at = [&](int i) { return corner[static_cast<std::size_t>(i & 3)]; };
    const bool cut = !joined;  // Side of the corners that the boundary cuts off.
    for (int i = 0; i < 4; ++i) {
        if (is_inside(inside, at(i)) == cut || is_inside(inside, at(i + 1)) != cut) {
            continue;
        }
        int j = i + 1;
        while (is_inside(inside, at(j + 1)) == cut) {
            ++j;
        }
        const int first = edge_between(at(i), at(i + 1)), last = edge_between(at(j), at(j + 1));
        next[static_cast<std::size_t>(cut ? first : last)] = cut ? last : first;
    }
}

std::vector<Loop> trace_loops(unsigned inside, unsigned joined) {
    Successors next;
    next.fill(-1);
    for (int face = 0; face < cell_face_count; ++face) {
        trace_face(inside, face, is_ambiguous(inside, face) && (joined >> face & 1) != 0, next);
    }
    std::vector<Loop> loops;
    for (std::size_t start = 0; start < next.size(); ++start) {
        Loop loop;
        for (std::size_t edge = start; next[edge] >= 0;) {
            loop.push_back(static_cast<std::uint8_t>(edge));
            edge = static_cast<std::size_t>(std::exchange(next[edge], -1));
        }
        if (!loop.empty()) {
            loops.push_back(std::move(loop));
        }
    }
    return loops;
}

void add_entry(unsigned inside, unsigned joined, CaseTable& table) {
    CaseEntry entry;
    entry.first_corner = static_cast<std::uint16_t>(table.corners.size());
    entry.first_ring = static_cast<std::uint16_t>(table.rings.size());
    for (const Loop& loop : trace_loops(inside, joined)) {
        std::vector<std::uint8_t> corners = triangulate_loop(loop);
        if (corners.empty()) {
            assert(entry.ring_size == 0);  // A cell has one center vertex.
            corners = fan_about_center(loop);
            table.rings.insert(table.rings.end(), loop.begin(), loop.end());
            entry.ring_size = static_cast<std::uint8_t>(loop.size());
            ++table.center_count;
        }
        table.corners.insert(table.corners.end(), corners.begin(), corners.end());
        entry.triangle_count = static_cast<std::uint8_t>(entry.triangle_count + corners.size() / 3);
    }
    assert(table.corners.size() <= std::numeric_limits<std::uint16_t>::max());
    table.entries.push_back(entry);
}

/// Spreads the low bits of `packed` over the set bits of `mask`.
unsigned spread(unsigned packed, unsigned mask) {
    unsigned bits = 0;
    for (; mask != 0; mask &= mask - 1, packed >>= 1) {
        if ((packed & 1) != 0) {
            bits |= mask & (~mask + 1);
        }
    }
    return bits;
}

/// Returns the ambiguous faces that join their inside corners, for rules that ignore the values.
unsigned fixed_decision(CaseRule rule, unsigned inside, unsigned ambiguous) {
    // The table of 1987 lists the cases with up to 4 inside corners, and separates these corners.
    // The other cases are complements, so there the outside corners are separate.
    return rule == CaseRule::lorensen1987 && std::popcount(inside) > 4 ? ambiguous : 0;
}

CaseTable generate(CaseRule rule, std::string_view name) {
    CaseTable table;
    table.name = name;
    table.decides_faces = rule == CaseRule::asymptotic;
    for (unsigned inside = 0; inside < 256; ++inside) {
        unsigned ambiguous = 0;
        for (int face = 0; face < cell_face_count; ++face) {
            if (is_ambiguous(inside, face)) {
                ambiguous |= 1U << face;
            }
        }
        table.ambiguous[inside] = static_cast<std::uint8_t>(ambiguous);
        table.first_entry[inside] = static_cast<std::uint16_t>(table.entries.size());
        if (!table.decides_faces) {
            add_entry(inside, fixed_decision(rule, inside, ambiguous), table);
            continue;
        }
        for (unsigned packed = 0; packed < 1U << std::popcount(ambiguous); ++packed) {
            add_entry(inside, spread(packed, ambiguous), table);
        }
    }
    table.slots = {case_slots(table, false), case_slots(table, true)};
    return table;
}

}  // namespace

std::array<int, 2> edge_corners(int edge) {
    assert(edge >= 0 && edge < cell_edge_count);
    const int i = edge & 1, j = edge >> 1 & 1;
    switch (edge >> 2) {
        case 0:
            return {i << 1 | j << 2, i << 1 | j << 2 | 1};
        case 1:
            return {i | j << 2, i | j << 2 | 2};
        default:
            return {i | j << 1, i | j << 1 | 4};
    }
}

std::array<int, 4> face_corners(int face) {
    assert(face >= 0 && face < cell_face_count);
    constexpr std::array<std::array<int, 4>, cell_face_count> corners = {
        {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
    return corners[static_cast<std::size_t>(face)];
}

const CaseEntry& CaseTable::entry(std::uint8_t inside, std::uint8_t joined) const {
    unsigned packed = 0;
    if (decides_faces) {
        unsigned bit = 1;
        for (unsigned mask = ambiguous[inside]; mask != 0; mask &= mask - 1, bit <<= 1) {
            if ((joined & mask & (~mask + 1)) != 0) {
                packed |= bit;
            }
        }
    }
    return entries[first_entry[inside] + packed];
}

const CaseTable& case_table(CaseRule rule) {
    static const CaseTable asymptotic = generate(CaseRule::asymptotic, "asymptotic");
    static const CaseTable lorensen1987 = generate(CaseRule::lorensen1987, "lorensen1987");
    static const CaseTable watertight = generate(CaseRule::watertight, "watertight");
    switch (rule) {
        case CaseRule::asymptotic:
            return asymptotic;
        case CaseRule::lorensen1987:
            return lorensen1987;
        case CaseRule::watertight:
            return watertight;
    }
    assert(false);
    return watertight;
}

}  // namespace pxpl5::gp
