// One Renderer: takes opcode streams for its regions, executes them, sends the finished regions.
//
//   BeginFrame     --->+----------+---> RegionPixels   (to the frame buffer)
//   RegionPrograms --->| Renderer |---> FrameCounts    (to the host, if it asked for them)
//   Topology       --->+----------+---> Fault          (to the host)
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string_view>

#include "renderer_firmware/fast/fast.hpp"
#include "renderer_firmware/node_frame.hpp"
#include "ringbus/node.hpp"

namespace pxpl5::renderer {

/// What a Renderer tells apart of its work, besides the stages of every node.
namespace stage {
using namespace bus::stage;
inline constexpr std::string_view plan = "plan";  ///< Of a frame or region; checks the programs.
inline constexpr std::string_view primitives = "primitives";        ///< All that GPs have sent.
inline constexpr std::string_view end_of_region = "end_of_region";  ///< Shading, readout.
}  // namespace stage

/// Role renderer. A frame is drawn, one region per call of work(), once its BeginFrame and the
/// RegionPrograms of every GP are here; frames are drawn in ascending order.
class RendererNode final : public bus::Node {
  public:
    /// Executes on the vector target that PXPL5_TARGET names, else the best.
    /// Throws std::invalid_argument if this machine lacks it.
    RendererNode();
    ~RendererNode() override;

    void receive(const bus::Message& message, bus::Outbox& out) override;
    bool work(bus::Outbox& out) override;
    bus::NodeStatus status() const override;

  private:
    struct Drawing;

    void on_topology(const bus::Message& message);
    void on_begin(const bus::Message& message);
    void on_programs(const bus::Message& message);
    FrameMessages& inputs_of(std::uint32_t frame);
    void start_next(bus::Outbox& out);
    bool goes_on_from_sums(bus::Outbox& out);
    void draw_next_region(bus::StageClock* clock);
    void send_counts(bus::Outbox& out);
    void send_pixels(bus::Outbox& out);
    void tell_faults(bus::Outbox& out);

    bus::NodeId self_ = 0, frame_buffer_ = 0;
    std::uint32_t index_ = 0;                         ///< Of this Renderer.
    std::map<std::uint32_t, bus::NodeId> gp_ids_;     ///< By index.
    std::map<std::uint32_t, FrameMessages> waiting_;  ///< By frame, those not yet drawn.
    std::optional<std::uint32_t> newest_drawn_;       ///< Frames up to it are over.
    std::uint64_t frames_ = 0;                        ///< Sent.
    fast::Fast executor_;
    std::optional<HeldSums> sums_;      ///< What its backing store holds.
    std::unique_ptr<Drawing> drawing_;  ///< The frame being drawn.
};

}  // namespace pxpl5::renderer
