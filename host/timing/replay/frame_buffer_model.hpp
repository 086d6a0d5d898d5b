// The frame buffers: pixels in, a swap at the retrace.
#pragma once

#include "host/timing/replay/frame_table.hpp"
#include "host/timing/replay/hardware.hpp"

namespace pxpl5::host::timing {

/// Source: README.md, "Frame", 6 and 8.
class FrameBufferModel {
  public:
    FrameBufferModel(Hardware& hardware, FrameTable& frames)
        : hardware_(hardware), frames_(frames) {}

    /// Where a region of a frame goes.
    Place port_of(std::uint32_t frame, std::uint32_t region) const;
    /// All pixels of a region have come.
    void region_in(std::uint32_t frame);

  private:
    void swap(std::uint32_t frame);
    void report_in(std::uint32_t frame);

    Hardware& hardware_;
    FrameTable& frames_;
};

}  // namespace pxpl5::host::timing
