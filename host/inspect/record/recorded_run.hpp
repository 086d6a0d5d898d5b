// A recorded run: what every node received, and the frames put together from it again.
//
//   traces/gp-0.mcap, renderer-3.mcap, ... --> RecordedRun --frame(7)--> RecordedFrame
//                                                                           regions: plans to
//                                                                           execute
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "renderer_firmware/node_frame.hpp"
#include "ringbus/trace/trace_file.hpp"

namespace pxpl5::host::inspect {

/// The messages that one node received, from a file or a test.
struct NodeTrace {
    bus::trace::Info info;
    std::vector<bus::trace::Entry> entries;  ///< In the order of receipt.
    std::function<bus::Message(const bus::trace::Entry&)> load;
    std::string cut;  ///< Why the trace ends early; empty if it does not.
};

/// Where a region lies. Views of a frame are stacked from the top; x and y count over all of them.
struct RegionPlace {
    std::uint32_t number = 0;
    int view = 0, column = 0, row = 0;
    int x0_px = 0, y0_px = 0;
};

/// One region, ready to be executed again.
struct RecordedRegion {
    RegionPlace place;
    std::uint32_t renderer = 0;
    renderer::RegionPlan plan;  ///< Points into the frame's messages.
    /// Only in a pass: the backing store at its begin holds the results of the region's parts of
    /// the earlier passes, executed one after the other. See prepare() in executors.hpp.
    renderer::RegionPlan before;
    std::vector<std::uint32_t> end_of_region;  ///< Only in a pass: the plan's, for the slot.
};

/// One frame. Keeps the messages that its regions point into.
struct RecordedFrame {
    RecordedFrame() = default;
    RecordedFrame(RecordedFrame&&) = default;  // Plans point into it: it moves, and has no copies.
    RecordedFrame& operator=(RecordedFrame&&) = default;

    std::uint32_t number = 0;
    std::optional<bus::Message> begin;                        ///< BeginFrame; always there.
    std::map<std::uint32_t, renderer::FrameMessages> inputs;  ///< By Renderer.
    std::map<std::uint32_t, renderer::FramePlan> plans;       ///< By Renderer.
    std::map<std::uint32_t, RecordedRegion> regions;  ///< By number; those that can be executed.
    std::vector<std::string> missing;        ///< Why other regions are missing, a sentence each.
    std::unique_ptr<RecordedFrame> earlier;  ///< Only in a pass: the pass before, if recorded.
    std::vector<bus::Message> done;  ///< FrameDone by frame buffer, if the host's trace has it.
    /// RegionPixels by Renderer, if they came: one for each frame buffer.
    std::multimap<std::uint32_t, bus::Message> pixels;
    std::vector<std::uint32_t> joined;  ///< The picture, if several frame buffers have sent it.

    const bus::schema::DrawFrame& draw() const {
        return *begin->as<bus::schema::BeginFrame>()->draw();
    }
    /// A frame of several whose mean the picture is, and not the last: nothing is read out of it.
    bool has_pixels() const { return draw().sample() + 1 == draw().samples(); }
    /// "sample 2 of 4"; empty if the frame is a picture of its own.
    std::string pass_text() const;
    /// Place of every region of the picture.
    RegionPlace place(std::uint32_t region) const;
    /// True if pixel (x, y) belongs to the whole picture, views stacked.
    bool contains(int x, int y) const {
        return x >= 0 && y >= 0 && x < static_cast<int>(draw().width()) &&
               y < static_cast<int>(draw().height() * draw().views()->size());
    }
    /// The region that holds pixel (x, y) of the whole picture, views stacked.
    /// Throws RequestError (usage) that names pixel and size if it is outside.
    RegionPlace region_at(int x, int y) const;
};

/// The volume that GPs held at some time, put together from their slices.
struct RecordedVolume {
    bus::Message header;                     ///< VolumeHeader.
    std::vector<bus::Message> slices;        ///< Keeps what `slice` points into.
    std::vector<const std::uint8_t*> slice;  ///< By z; null where no trace has it.

    /// Voxel (x, y, z). Nothing if it is outside or its slice is not recorded.
    std::optional<double> value(int x, int y, int z) const;
};

class RecordedRun {
  public:
    /// Opens a run folder, its traces/ folder, or one trace file.
    /// Throws RequestError: usage if there is no trace, bad_data naming the file otherwise.
    static RecordedRun open(const std::filesystem::path& path);

    /// Puts traces together. Throws RequestError (bad_data) if no trace has a Topology.
    explicit RecordedRun(std::vector<NodeTrace> nodes);

    /// By node id.
    const std::map<bus::NodeId, NodeTrace>& nodes() const { return nodes_; }
    const NodeTrace* find(bus::schema::Role role, std::uint32_t index) const;
    std::string node_name(bus::NodeId id) const;  ///< "gp-3"; "node-77" if not of this machine.
    std::uint32_t gp_count() const { return gp_count_; }
    std::uint32_t renderer_count() const { return renderer_count_; }
    std::uint32_t frame_buffer_count() const { return frame_buffer_count_; }

    /// Numbers of the frames that began, ascending.
    std::vector<std::uint32_t> frames() const;
    /// Throws RequestError (usage) that names the frames there are.
    RecordedFrame frame(std::uint32_t number) const;

    /// The volume that the frame shows. Nothing if no trace has its header.
    std::optional<RecordedVolume> volume(std::uint32_t frame) const;
    /// The volume of which this is the VolumeHeader, with the slices that traces have. Slices whose
    /// size differs from the header's shape are left out.
    RecordedVolume volume_of(const bus::Message& header) const;
    /// The SetSurface that gave `surface` this revision, if recorded.
    std::optional<bus::Message> surface(std::uint16_t surface, std::uint32_t revision) const;

  private:
    /// Where a frame's messages lie.
    struct FrameIndex {
        struct At {
            bus::NodeId node = 0;
            std::size_t entry = 0;
        };
        std::optional<At> begin;
        std::map<bus::NodeId, At> done;                                 ///< By frame buffer.
        std::map<std::uint32_t, At> begins;                             ///< By Renderer.
        std::map<std::uint32_t, std::map<std::uint32_t, At>> programs;  ///< By Renderer, GP.
        std::multimap<std::uint32_t, At> pixels;                        ///< By Renderer.
    };
    void add_earlier(RecordedFrame& frame) const;
    void index_node(bus::NodeId id, const NodeTrace& node);
    void index_entry(FrameIndex::At at, const bus::Message& message);
    std::uint32_t index_of(bus::NodeId id) const;
    bus::Message load(FrameIndex::At at) const;

    std::map<bus::NodeId, NodeTrace> nodes_;
    std::map<bus::NodeId, std::pair<bus::schema::Role, std::uint32_t>> roles_;
    std::uint32_t gp_count_ = 0, renderer_count_ = 0, frame_buffer_count_ = 0;
    std::map<std::uint32_t, FrameIndex> frames_;
};

}  // namespace pxpl5::host::inspect
