// One Renderer: receives opcode streams for its regions, executes them, sends the regions.
//
//   BeginFrame     --->+----------+---> RegionPixels   (to the frame buffers)
//   RegionPrograms --->| Renderer |---> FrameCounts    (to the host, on request)
//   Topology       --->+----------+---> Fault          (to the host)
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "renderer_firmware/fast/fast.hpp"
#include "renderer_firmware/node_frame.hpp"
#include "ringbus/node.hpp"

namespace pxpl5::renderer {

/// Stages of a Renderer, besides the stages of every node.
namespace stage {
using namespace bus::stage;
inline constexpr std::string_view plan = "plan";              ///< Planning; checks the programs.
inline constexpr std::string_view primitives = "primitives";  ///< All segments of the GPs.
inline constexpr std::string_view end_of_region = "end_of_region";  ///< Shading, readout.
}  // namespace stage

/// The role renderer. Draws a frame when its BeginFrame and the RegionPrograms of all GPs have
/// arrived, one region per call of work(). Draws frames in ascending order.
class RendererNode final : public bus::Node {
  public:
    /// Executes on the vector target that PXPL5_TARGET names, or on the best one.
    /// Throws std::invalid_argument if this computer does not have the target.
    RendererNode();
    ~RendererNode() override;

    void receive(const bus::Message& message, bus::Outbox& out) override;
    bool work(bus::Outbox& out) override;
    bus::NodeStatus status() const override;
    bus::Doing doing() override;

  private:
    struct Drawing;

    void on_topology(const bus::Message& message);
    void on_begin(const bus::Message& message);
    void on_programs(const bus::Message& message);
    FrameMessages& inputs_of(std::uint32_t frame);
    bool draw(bus::Outbox& out);
    void start_next(bus::Outbox& out);
    bool goes_on_from_sums(bus::Outbox& out);
    void draw_next_region(bus::StageClock* clock);
    void send_counts(bus::Outbox& out);
    void send_pixels(bus::Outbox& out);
    void tell_faults(bus::Outbox& out);

    bus::NodeId self_ = 0;
    std::vector<bus::NodeId> frame_buffers_;          ///< By index.
    std::uint32_t index_ = 0;                         ///< Index of this Renderer.
    std::map<std::uint32_t, bus::NodeId> gp_ids_;     ///< GP by index.
    std::map<std::uint32_t, FrameMessages> waiting_;  ///< Frames that are not yet drawn.
    std::optional<std::uint32_t> newest_drawn_;       ///< Older frames are finished.
    std::uint64_t frames_ = 0;                        ///< Number of sent frames.
    fast::Fast executor_;
    std::optional<HeldSums> sums_;      ///< Contents of the backing store.
    std::unique_ptr<Drawing> drawing_;  ///< The current frame.
};

}  // namespace pxpl5::renderer
