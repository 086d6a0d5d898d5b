#include "gp_firmware/surface/case_slots.hpp"

#include <span>

#include "gp_firmware/surface/case_tables.hpp"

namespace pxpl5::gp {

CaseSlots case_slots(const CaseTable& table, bool flip) {
    CaseSlots slots;
    for (std::size_t inside = 0; inside < 256; ++inside) {
        slots.has_ambiguous_face[inside] = table.ambiguous[inside] != 0 ? 1 : 0;
        const CaseEntry& entry = table.entries[table.first_entry[inside]];
        const std::span<const std::uint8_t> corners = table.corners_of(entry);
        if ((table.decides_faces && table.ambiguous[inside] != 0) || entry.ring_size != 0 ||
            corners.size() > max_listed_corners) {
            slots.corner_count[inside] = unlisted;
            continue;
        }
        slots.corner_count[inside] = static_cast<std::uint8_t>(corners.size());
        for (std::size_t i = 0; i < corners.size(); ++i) {
            const std::size_t turned = flip && i % 3 != 0 ? 3 - i % 3 : i % 3;
            const std::size_t corner = corners[i - i % 3 + turned];
            for (const std::size_t parity : {0U, 1U}) {
                slots.corners[parity][inside][i] =
                    static_cast<std::uint8_t>(slot_of_edge(corner, parity));
            }
        }
    }
    return slots;
}

}  // namespace pxpl5::gp
