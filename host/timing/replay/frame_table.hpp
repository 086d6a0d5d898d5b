// The frames that are under way.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "host/timing/replay/events.hpp"
#include "host/timing/replay/frame_plan.hpp"

namespace pxpl5::host::timing {

struct FrameRun {
    std::shared_ptr<const FramePlan> plan;  ///< Until the host knows that the frame is shown.
    std::vector<std::uint16_t> assignment;  ///< Renderer of each region; empty if handed out.
    std::vector<std::uint32_t> order;       ///< In which regions are handed out.
    std::vector<std::uint16_t> ready;       ///< GPs whose bins are complete, in that order.
    std::size_t regions = 0;
    std::size_t regions_due = 0;  ///< Regions that are incomplete in the frame buffer.
    std::size_t reports_due = 0;  ///< Frame buffers whose FrameDone has not come to the host.
    Callback<> complete;          ///< The last pixel is in the frame buffer.
    Callback<> shown;             ///< Swapped in; of a pass: complete.
    Callback<> known;             ///< The host knows the frame.
};

/// All frames of a run by number, from 0. Addresses stay.
using FrameTable = std::deque<FrameRun>;

}  // namespace pxpl5::host::timing
