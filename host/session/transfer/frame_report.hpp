// The figures of a picture that was drawn.
#pragma once

#include <cstdint>
#include <vector>

#include "host/session/transfer/frame_parts.hpp"

namespace pxpl5::host {

/// Sums over all passes and layers that were drawn for a picture.
struct FrameReport {
    std::uint32_t frame = 0;           ///< Number of the last pass.
    std::int64_t instructions = 0;     ///< Executed by all Renderers.
    std::int64_t renderer_cycles = 0;  ///< Modelled, summed over regions.
    double elapsed_ms = 0;             ///< Request to picture.
    double moved_mm = 0;  ///< No point of a simplified surface is farther from the exact surface.
    int region_columns = 0, region_rows = 0;      ///< Rows over all views.
    std::vector<std::uint64_t> region_cycles;     ///< Modelled, by region.
    std::vector<std::uint16_t> region_renderers;  ///< Index of the Renderer, by region.
};

/// Adds one pass to the report of its picture, except the time. All passes assign the regions to
/// the same Renderers.
void add_pass(const WholeFrame& done, FrameReport& report);

}  // namespace pxpl5::host
