// A frame's way through the machine, from the host's command to its knowledge.
#pragma once

#include <deque>
#include <memory>

#include "host/timing/replay/frame_buffer_model.hpp"
#include "host/timing/replay/frame_table.hpp"
#include "host/timing/replay/hardware.hpp"
#include "host/timing/replay/renderer_model.hpp"

namespace pxpl5::host::timing {

/// Source: README.md, "Frame".
class FrameModel {
  public:
    explicit FrameModel(Hardware& hardware);

    /// The host asks for a frame, behind those that it has asked for.
    void draw(FrameRun frame);

  private:
    bool hands_out() const { return is_handed_out(hardware_.machine.assignment); }
    void begin(std::uint32_t frame);
    void broadcast(std::uint32_t frame);
    void gp_begins(std::uint32_t frame, std::uint16_t gp);
    void gp_ready(std::uint32_t frame, std::uint16_t gp);
    void renderer_begins(std::uint32_t frame, std::uint16_t renderer);
    void ask(std::uint16_t renderer);
    void hand_out();
    void assign(std::uint16_t renderer, std::uint32_t frame, std::uint32_t region);

    Hardware& hardware_;
    FrameTable frames_;
    FrameBufferModel buffers_;
    std::deque<RendererModel> renderers_;
    // The Master's.
    std::deque<std::uint16_t> wants_region_;  ///< Renderers, in the order of their requests.
    std::uint32_t begun_ = 0;                 ///< Frames.
    std::uint32_t next_frame_ = 0, next_region_ = 0;  ///< Next numbers to assign.
};

}  // namespace pxpl5::host::timing
