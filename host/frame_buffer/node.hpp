// The frame buffer: puts finished regions together into frames, and swaps.
//
//   BeginFrame   --->+--------------+---> FrameDone   (to the host)
//   RegionPixels --->| frame buffer |---> Fault
//   Topology     --->+--------------+
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "host/frame_buffer/frame.hpp"
#include "ringbus/node.hpp"

namespace pxpl5::host {

/// Role frame_buffer. A frame is complete when every Renderer has sent its RegionPixels. Frames
/// complete in order, because every Renderer sends its frames in order.
class FrameBufferNode final : public bus::Node {
  public:
    void receive(const bus::Message& message, bus::Outbox& out) override;
    bool work(bus::Outbox& out) override;

  private:
    void on_topology(const bus::schema::Topology& topology);
    void on_begin_frame(const bus::schema::BeginFrame& begin, bus::Outbox& out);
    void on_region_pixels(const bus::Message& message, bus::Outbox& out);
    void take_tiles(Frame& frame, const bus::schema::RegionPixels& pixels);
    void swap_if_complete(bus::Outbox& out);
    void hold(const bus::Message& message, std::uint32_t frame);
    std::string late_reason(const bus::schema::RegionPixels& pixels) const;

    std::vector<bus::NodeId> renderer_ids_;  ///< By index.
    std::deque<Frame> in_flight_;            ///< Oldest first.
    std::vector<bus::Message> early_;        ///< Regions that overtook their BeginFrame.
    std::vector<std::uint32_t> front_;       ///< Pixels of the frame that is shown.
    std::uint32_t next_frame_ = 0;           ///< Frames below this have begun.
};

}  // namespace pxpl5::host
