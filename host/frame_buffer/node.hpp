// The frame buffer: puts finished regions together into frames, and swaps.
//
//   BeginFrame   --->+--------------+---> FrameDone   (to the host)
//   RegionPixels --->| frame buffer |---> Fault
//   Topology     --->+--------------+
#pragma once

#include <cstdint>
#include <deque>
#include <string_view>
#include <vector>

#include "host/frame_buffer/frame.hpp"
#include "ringbus/node.hpp"

namespace pxpl5::host {

/// Kinds of work of the frame buffer, besides the stages of every node.
namespace stage {
using namespace bus::stage;
inline constexpr std::string_view assemble = "assemble";  ///< Regions into their picture.
}  // namespace stage

/// A frame and the message in which it goes to the host: regions are put in their places there.
struct FrameInFlight {
    using Words = flatbuffers::Offset<flatbuffers::Vector<std::uint32_t>>;

    Frame frame;  ///< Its pictures lie in `body`.
    flatbuffers::FlatBufferBuilder body;
    Words picture, depths;
};

/// Role frame_buffer. Assembles the views that frame_buffer_of() gives it. A frame is complete when
/// every Renderer has sent its RegionPixels of these views. Frames complete in order, because every
/// Renderer sends its frames in order.
class FrameBufferNode final : public bus::Node {
  public:
    void receive(const bus::Message& message, bus::Outbox& out) override;
    bool work(bus::Outbox& out) override;
    bus::NodeStatus status() const override;

  private:
    void on_topology(const bus::Message& message);
    void on_begin_frame(const bus::schema::BeginFrame& begin, bus::Outbox& out);
    void on_region_pixels(const bus::Message& message, bus::Outbox& out);
    void check_sender(bus::NodeId source, const bus::schema::RegionPixels& pixels) const;
    /// Keeps regions that overtook their BeginFrame.
    void hold(const bus::Message& message);
    void take_early(bus::Outbox& out);
    /// Drops older frames: a Renderer that failed at one never sends it.
    void give_up_before(std::uint32_t number);
    /// Shows the oldest frame, which is complete, and notifies the host.
    void swap_in(bus::Outbox& out);

    ViewShare share_;
    std::vector<bus::NodeId> renderer_ids_;  ///< By index.
    std::deque<FrameInFlight> in_flight_;    ///< Oldest first.
    std::vector<bus::Message> early_;        ///< Regions that overtook their BeginFrame.
    std::uint32_t next_frame_ = 0;           ///< Frames below this have begun.
    std::uint64_t frames_ = 0;               ///< Sent.
};

}  // namespace pxpl5::host
