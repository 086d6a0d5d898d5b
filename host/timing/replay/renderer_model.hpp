// A Renderer: takes bins in, works through its FIFO, reads regions out.
#pragma once

#include <deque>
#include <vector>

#include "host/timing/replay/frame_buffer_model.hpp"
#include "host/timing/replay/frame_table.hpp"
#include "host/timing/replay/hardware.hpp"

namespace pxpl5::host::timing {

/// Source: README.md, "Frame", 4 to 7.
class RendererModel {
  public:
    /// `asks` is called when the Renderer wants its next region.
    RendererModel(Hardware& hardware, FrameTable& frames, FrameBufferModel& buffers,
                  std::size_t index, Callback<> asks)
        : hardware_(hardware), frames_(frames), buffers_(buffers), index_(index), asks_(asks) {}

    /// The Renderer is to draw a region, behind those that it has.
    void add(std::uint32_t frame, std::uint32_t region);
    /// One more GP has its bins of some frame complete.
    void gp_ready();

  private:
    enum class Doing : std::uint8_t { nothing, prologue, packet, end, stalled };
    struct Draw {
        std::uint32_t frame = 0, region = 0;
        std::vector<Ns>
            sendable;  ///< When each GP's software is ready, in FrameRun::ready's order.
        std::size_t looked_at = 0;    ///< GPs whose bins were sent, or are empty.
        std::uint64_t words_due = 0;  ///< Words of sent bins that are not worked yet.
        bool begun = false;           ///< The prologue.
        bool complete = false;        ///< All bins were sent.
        std::vector<bool> doors_paid;
    };
    struct Queued {
        std::uint32_t draw = 0;  ///< Its number.
        std::uint32_t words = 0;
        Ns time = 0;
    };

    Draw& draw(std::uint32_t number) { return draws_[number - first_]; }
    void prepare(Draw& draw);
    void bring();
    void send_bin(std::uint32_t number, std::uint16_t gp);
    void arrive(std::uint32_t number, std::uint16_t gp, Packet packet);
    Ns work_of(Draw& draw, std::uint16_t gp, Packet packet) const;
    void go_on();
    void start(Doing doing, Ns time);
    void finish();
    void leave();
    void send_pixels(std::uint32_t frame, std::uint32_t region);
    void readout_over();

    UseMeter& use() { return hardware_.renderers[index_]; }

    Hardware& hardware_;
    FrameTable& frames_;
    FrameBufferModel& buffers_;
    std::size_t index_;
    Callback<> asks_;
    std::deque<Draw> draws_;    ///< The first is being drawn.
    std::uint32_t first_ = 0;   ///< Number of the first one.
    std::uint32_t brings_ = 0;  ///< Number of the one whose bins come.
    bool bin_comes_ = false;
    std::deque<Queued> fifo_;  ///< Packets that have come, the first one perhaps under work.
    Doing doing_ = Doing::nothing;
    bool reads_out_ = false;
};

}  // namespace pxpl5::host::timing
