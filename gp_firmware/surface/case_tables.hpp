// The case tables of marching cubes: the triangles of a cell for each set of inside corners.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "generated/vocabulary.hpp"
#include "gp_firmware/surface/case_slots.hpp"

namespace pxpl5::gp {

// Corner c of a cell is at (c & 1, c >> 1 & 1, c >> 2). Edges 0..3 run along x from the corners
// with (y, z) = (e & 1, e >> 1), edges 4..7 along y by (x, z), edges 8..11 along z by (x, y).
// Faces 0..5: x low, x high, y low, y high, z low, z high.
inline constexpr int cell_edge_count = 12;
inline constexpr int cell_face_count = 6;
inline constexpr std::uint8_t center_corner = 12;  ///< Triangle corner: the cell's own vertex.

/// The triangles of one case.
struct CaseEntry {
    std::uint16_t first_corner = 0;  ///< Into CaseTable::corners; 3 per triangle.
    std::uint16_t first_ring = 0;    ///< Into CaseTable::rings.
    std::uint8_t triangle_count = 0;
    std::uint8_t ring_size = 0;  ///< Edges around the center vertex; 0 if there is none.
};

/// All cases of one rule. A case is a set of inside corners and a set of ambiguous faces that join
/// them.
struct CaseTable {
    std::string_view name;
    bool decides_faces = false;                    ///< Whether entries depend on face decisions.
    std::array<std::uint8_t, 256> ambiguous{};     ///< Bit f: face f is ambiguous.
    std::array<std::uint16_t, 256> first_entry{};  ///< Indexed by the set of inside corners.
    std::vector<CaseEntry> entries;
    std::vector<std::uint8_t> corners;  ///< Edge 0..11 or center_corner; counter-clockwise seen
                                        ///< from outside in a right-handed frame.
    std::vector<std::uint8_t> rings;    ///< Edges whose mean is the center vertex.
    int center_count = 0;               ///< Entries that need a center vertex.
    std::array<CaseSlots, 2> slots;     ///< [1] has all triangles turned over.

    /// inside  Bit c: corner c is inside.
    /// joined  Bit f: on ambiguous face f the inside corners are joined. Other bits are ignored.
    const CaseEntry& entry(std::uint8_t inside, std::uint8_t joined) const;
    std::span<const std::uint8_t> corners_of(const CaseEntry& entry) const {
        return {corners.data() + entry.first_corner, std::size_t{entry.triangle_count} * 3};
    }
    std::span<const std::uint8_t> ring_of(const CaseEntry& entry) const {
        return {rings.data() + entry.first_ring, entry.ring_size};
    }
};

/// Returns the two corners of an edge, the lower voxel first.
std::array<int, 2> edge_corners(int edge);

/// Returns the corners of a face in cyclic order, counter-clockwise seen from outside of the cell.
std::array<int, 4> face_corners(int face);

/// Returns the table, which is generated at first use.
/// Source  Lorensen & Cline 1987 for the idea and the complement rule of `lorensen1987`; the face
///         test is the asymptotic decider of Nielson & Hamann 1991; the generator is ours.
const CaseTable& case_table(CaseRule rule);

}  // namespace pxpl5::gp
