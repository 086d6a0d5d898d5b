// A region's instructions as assembly with what each of them did, by executing them again.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "host/base/text_output.hpp"
#include "host/inspect/listing/instruction_values.hpp"
#include "host/inspect/record/region_walk.hpp"
#include "host/inspect/record/selection.hpp"

namespace pxpl5::host::inspect {

struct RegionListing {
    const Selection& selection;        ///< Selects parts (GP, surface, slab) and instructions.
    std::optional<RegionPixel> pixel;  ///< Whose values are shown; else the first enabled one's.
    std::uint64_t max_lines = 0;       ///< Instructions to list.
};

/// Instructions that the selection names.
struct ListedLines {
    std::uint64_t listed = 0, left_out = 0;
};

/// True if the selection names the part: a segment, or, if it names no GP, surface and slab, any.
bool has_part(const Selection& selection, const renderer::RegionPlan::Part& part);

// Comment lines of assembly: what a part is, and a primitive.
std::string part_heading(const renderer::RegionPlan::Part& part);
std::string primitive_heading(const Primitive& primitive, const renderer::RegionPlan& plan);

/// Explains the columns to new users.
std::string listing_legend(bool pixel_is_chosen);

ListedLines list_region(const RecordedFrame& frame, const RecordedRegion& region,
                        const RegionListing& options, TextOutput& output);

}  // namespace pxpl5::host::inspect
