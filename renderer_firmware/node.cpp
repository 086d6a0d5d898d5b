#include "renderer_firmware/node.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <new>
#include <span>
#include <utility>

#include "isa/contract/sample_sums.hpp"
#include "renderer_firmware/node_output.hpp"
#include "ringbus/rules/regions.hpp"
#include "ringbus/rules/views.hpp"

namespace pxpl5::renderer {

namespace {

namespace schema = bus::schema;
using bus::NodeFault;
using schema::FaultCode;

/// Two frames are in flight on the machine. Two more may have lost a message.
constexpr std::size_t max_waiting_frames = 4;

/// Limits the reported faults of one frame. More faults would add no information.
constexpr std::size_t max_faults = 16;

[[noreturn]] void refuse(FaultCode code, const std::string& reason) {
    throw NodeFault(code, reason);
}

/// Returns the words in the order of the message.
schema::PartCounts to_wire(std::uint32_t region, const PartCounts& part) {
    std::array<schema::ClassCounts, isa::class_count> classes;
    std::ranges::transform(part.executed.classes, classes.begin(), [](const isa::ClassCounts& c) {
        return schema::ClassCounts(c.instructions, c.cycles);
    });
    return {static_cast<std::uint16_t>(region),
            static_cast<std::uint16_t>(part.surface),
            part.kind,
            part.slab,
            part.primitives,
            part.words,
            part.executed.port_cycles,
            part.executed.backing_cycles,
            flatbuffers::make_span(classes)};
}

std::uint64_t held_bytes(const FrameMessages& messages) {
    std::uint64_t bytes = messages.begin ? messages.begin->bytes().size() : 0;
    for (const auto& [gp, message] : messages.programs) {
        bytes += message.bytes().size();
    }
    return bytes;
}

}  // namespace

/// A frame whose messages have all arrived. The readout of its regions goes directly into the
/// messages to the frame buffers.
struct RendererNode::Drawing {
    Drawing(FrameMessages messages, std::uint32_t renderer, std::size_t frame_buffers,
            flatbuffers::Allocator* memory)
        : inputs(std::move(messages)),
          plan(plan_frame(inputs, renderer)),
          programs(region_frame(plan.programs)) {
        const schema::DrawFrame& draw = *inputs.begin->as<schema::BeginFrame>()->draw();
        regions_per_view = region_count(draw.width(), draw.height(), 1);
        std::vector<OutputRegions> counts_of(
            std::min<std::size_t>(draw.views()->size(), frame_buffers));
        const bool reads_depths = !plan.programs.depths.empty();
        for (const FramePlan::Region& region : plan.regions) {
            OutputRegions& to =
                counts_of[frame_buffer_of(region.number / regions_per_view, counts_of.size())];
            to.all += 1;
            to.with_pixels += plan.pass.is_last() ? 1 : 0;
            to.with_depths += reads_depths && draws(region.segments) ? 1 : 0;
        }
        for (OutputRegions& each : counts_of) {
            each.reads_depths = reads_depths;
            outputs.emplace_back(each, memory);
        }
    }
    RegionOutput& output_of(const FramePlan::Region& region) {
        return outputs[frame_buffer_of(region.number / regions_per_view, outputs.size())];
    }

    FrameMessages inputs;  ///< Owns the messages that the plan points into.
    FramePlan plan;
    RegionFrame programs;  ///< The Renderer's own programs.
    std::size_t next_region = 0, regions_per_view = 0;
    std::vector<RegionOutput> outputs;       ///< By frame buffer; of those that have a view.
    std::vector<schema::PartCounts> counts;  ///< Counts of the drawn regions, if requested.
    std::vector<schema::FaultT> faults;      ///< Faults to report.
    std::size_t fault_count = 0;

    void note(FaultCode code, std::uint32_t gp, const std::string& reason);
};

/// Records a fault in the messages of `gp` for the host.
void RendererNode::Drawing::note(FaultCode code, std::uint32_t gp, const std::string& reason) {
    if (++fault_count > max_faults) {
        return;
    }
    schema::FaultT fault;
    fault.code = code;
    fault.frame = plan.frame;
    fault.request = static_cast<std::uint16_t>(schema::Body::BeginFrame);
    if (const auto from = inputs.programs.find(gp); from != inputs.programs.end()) {
        fault.source = from->second.source();
        fault.request = from->second.header().kind();
        fault.sequence = from->second.header().sequence();
    }
    fault.reason =
        fmt::format("frame {}, {}{}", plan.frame, reason,
                    fault_count == max_faults ? "; further faults are not reported" : "");
    faults.push_back(std::move(fault));
}

RendererNode::RendererNode() = default;
RendererNode::~RendererNode() = default;

void RendererNode::receive(const bus::Message& message, bus::Outbox&) {
    switch (message.kind()) {
        case schema::Body::Topology:
            return on_topology(message);
        case schema::Body::BeginFrame:
            return on_begin(message);
        case schema::Body::RegionPrograms:
            return on_programs(message);
        default:
            refuse(FaultCode::bad_message,
                   fmt::format("a Renderer does not accept {}", bus::kind_name(message.kind())));
    }
}

bus::NodeStatus RendererNode::status() const {
    std::uint64_t bytes = drawing_ ? held_bytes(drawing_->inputs) : 0;
    for (const auto& [frame, messages] : waiting_) {
        bytes += held_bytes(messages);
    }
    return {bytes, waiting_.size() + (drawing_ ? 1 : 0), frames_};
}

bus::Doing RendererNode::doing() {
    if (!drawing_) {
        return {};
    }
    return {bus::Body::RegionPrograms, drawing_->plan.frame,
            static_cast<std::uint32_t>(drawing_->next_region),
            static_cast<std::uint32_t>(drawing_->plan.regions.size())};
}

void RendererNode::on_topology(const bus::Message& message) {
    self_ = message.header().destination();
    gp_ids_.clear();
    frame_buffers_.clear();
    bool found_self = false;
    for (const schema::NodeInfo* node : *message.as<schema::Topology>()->nodes()) {
        if (node->role() == schema::Role::gp) {
            gp_ids_[node->index()] = node->id();
        } else if (node->role() == schema::Role::frame_buffer) {
            frame_buffers_.resize(std::max<std::size_t>(frame_buffers_.size(), node->index() + 1U));
            frame_buffers_[node->index()] = node->id();
        } else if (node->role() == schema::Role::renderer && node->id() == self_) {
            index_ = node->index();
            found_self = true;
        }
    }
    if (!found_self || frame_buffers_.empty() || gp_ids_.empty()) {
        refuse(FaultCode::bad_input,
               fmt::format("topology: node {} is {}a Renderer; there are {} GPs and {} frame "
                           "buffers",
                           self_, found_self ? "" : "not ", gp_ids_.size(), frame_buffers_.size()));
    }
}

/// Returns the inputs of `frame`. Adds them if necessary. Throws NodeFault if the frame is over.
FrameMessages& RendererNode::inputs_of(std::uint32_t frame) {
    if (newest_drawn_ && frame <= *newest_drawn_) {
        refuse(FaultCode::bad_message,
               fmt::format("frame {}: frame {} is already drawn", frame, *newest_drawn_));
    }
    if (!waiting_.contains(frame) && waiting_.size() == max_waiting_frames) {
        refuse(FaultCode::bad_message,
               fmt::format("frame {}: {} frames from {} on are waiting; the limit is {}", frame,
                           waiting_.size(), waiting_.begin()->first, max_waiting_frames));
    }
    return waiting_[frame];
}

void RendererNode::on_begin(const bus::Message& message) {
    const auto& begin = *message.as<schema::BeginFrame>();
    const schema::DrawFrame& draw = *begin.draw();
    const std::size_t regions = region_count(draw.width(), draw.height(), draw.views()->size());
    if (begin.assignment()->size() != regions) {
        refuse(FaultCode::bad_message,
               fmt::format("frame {}: the assignment has {} regions, but the frame has {}",
                           draw.frame(), begin.assignment()->size(), regions));
    }
    const auto ours = static_cast<std::size_t>(std::ranges::count(*begin.assignment(), index_));
    if (ours > isa::max_summed_regions(draw.samples())) {
        refuse(FaultCode::bad_message,
               fmt::format(
                   "frame {}: Renderer {} has {} regions, but can sum {} samples of at most {}",
                   draw.frame(), index_, ours, draw.samples(),
                   isa::max_summed_regions(draw.samples())));
    }
    if (frame_buffers_.empty()) {
        refuse(FaultCode::bad_input,
               fmt::format("frame {}: the topology has no frame buffer", draw.frame()));
    }
    FrameMessages& inputs = inputs_of(draw.frame());
    if (inputs.begin) {
        refuse(FaultCode::bad_message,
               fmt::format("frame {}: BeginFrame arrived twice", draw.frame()));
    }
    inputs.begin = message;
}

void RendererNode::on_programs(const bus::Message& message) {
    const auto& programs = *message.as<schema::RegionPrograms>();
    const auto gp = gp_ids_.find(programs.gp());
    if (gp == gp_ids_.end() || gp->second != message.source()) {
        refuse(FaultCode::bad_message,
               fmt::format("frame {}: node {} sends programs as GP {}, of {} GPs", programs.frame(),
                           message.source(), programs.gp(), gp_ids_.size()));
    }
    if (!inputs_of(programs.frame()).programs.emplace(programs.gp(), message).second) {
        refuse(FaultCode::bad_message, fmt::format("frame {}: the programs of GP {} arrived twice",
                                                   programs.frame(), programs.gp()));
    }
}

bool RendererNode::work(bus::Outbox& out) {
    try {
        return draw(out);
    } catch (const std::bad_alloc&) {
        // A part of the frame is missing, so the rest is of no use to the frame buffer.
        executor_.read_out_into({});
        drawing_.reset();
        sums_.reset();
        throw NodeFault(FaultCode::out_of_memory, bus::memory_exhausted,
                        {schema::Body::BeginFrame, newest_drawn_});
    }
}

/// Does a piece of the frame that is being drawn, or begins the next.
bool RendererNode::draw(bus::Outbox& out) {
    if (!drawing_) {
        start_next(out);
    }
    if (!drawing_) {
        return false;
    }
    if (drawing_->next_region < drawing_->plan.regions.size()) {
        draw_next_region(out.clock());
    }
    tell_faults(out);
    if (drawing_->next_region == drawing_->plan.regions.size()) {
        if (std::exchange(drawing_->plan.counts, false)) {
            send_counts(out);
        }
        send_pixels(out);
    }
    return true;
}

/// Begins to draw the oldest frame whose messages have all arrived.
void RendererNode::start_next(bus::Outbox& out) {
    const bus::StageClock::In planning(out.clock(), stage::plan);
    const auto complete = std::find_if(waiting_.begin(), waiting_.end(), [&](const auto& entry) {
        return entry.second.begin && entry.second.programs.size() == gp_ids_.size();
    });
    if (complete == waiting_.end()) {
        return;
    }
    newest_drawn_ = complete->first;
    FrameMessages inputs = std::move(complete->second);
    const auto newer = waiting_.erase(complete);
    auto drawing = std::make_unique<Drawing>(std::move(inputs), index_, frame_buffers_.size(),
                                             out.body_allocator());
    // Senders keep their order, so the missing messages of older frames are lost.
    for (auto old = waiting_.begin(); old != newer; ++old) {
        drawing->faults.push_back(lost_frame(old->first, old->second, gp_ids_.size()));
    }
    waiting_.erase(waiting_.begin(), newer);
    for (const FrameFault& fault : drawing->plan.faults) {
        drawing->note(fault.code, fault.gp, fault.reason);
    }
    drawing_ = std::move(drawing);
    if (!goes_on_from_sums(out)) {
        drawing_.reset();
    }
}

/// Prepares the backing store for the frame. If the frame is a pass and the sums of the earlier
/// passes are missing, records a fault and returns false: the picture would be wrong.
bool RendererNode::goes_on_from_sums(bus::Outbox& out) {
    const FramePlan& plan = drawing_->plan;
    const std::string missing = missing_sums(sums_, plan);
    sums_.reset();
    if (!missing.empty()) {
        drawing_->note(FaultCode::lost_message, no_gp, missing);
        tell_faults(out);
        return false;
    }
    if (plan.pass.sample == 0) {
        executor_.reset();
    }
    sums_ = sums_behind(plan);
    return true;
}

void RendererNode::draw_next_region(bus::StageClock* clock) {
    const bus::StageClock::In drawing(clock, stage::plan);
    const std::size_t place = drawing_->next_region++;
    FramePlan::Region& region = drawing_->plan.regions[place];
    RegionOutput& output = drawing_->output_of(region);
    const bool has_depths = !drawing_->programs.depths.empty() && draws(region.segments);
    // Discards the readout of segments. Our GPs' segments read nothing out.
    const auto route = [&](PartKind kind) {
        drawing.enter(kind < PartKind::depths ? stage::primitives : stage::end_of_region);
        executor_.read_out_into(kind == PartKind::end_of_region ? output.next_pixels()
                                : kind == PartKind::depths      ? output.next_depths()
                                                                : std::span<std::uint32_t>());
    };
    RegionFrame& programs = drawing_->programs;
    std::vector<std::uint32_t> end;  // The program of this region, if it has a slot.
    if (const std::uint32_t samples = drawing_->plan.pass.samples; samples > 1) {
        end = at_slot(drawing_->plan.programs.end_of_region, samples, place);
        programs.end_of_region = end;
        programs.holds_sums = true;
        executor_.reset_pixels();
    } else {
        executor_.reset();
    }
    const RegionResult result =
        draw_region(executor_, programs, std::move(region.segments), route,
                    drawing_->plan.counts ? Counting::each_part : Counting::whole_region);
    drawing.enter(stage::plan);
    executor_.read_out_into({});
    output.add({static_cast<std::uint16_t>(region.number), has_depths, result.counts.cycles,
                result.counts.instructions});
    for (const PartCounts& part : result.parts) {
        drawing_->counts.push_back(to_wire(region.number, part));
    }
    for (const SegmentFault& fault : result.faults) {
        drawing_->note(
            FaultCode::bad_instruction, fault.gp,
            fmt::format("{}: {}", place_of(fault.gp, region.number, fault.surface, fault.slab),
                        fault.reason));
    }
}

void RendererNode::tell_faults(bus::Outbox& out) {
    for (schema::FaultT& fault : drawing_->faults) {
        fault.node = self_;
        out.send(bus::host_id, bus::pack(fault));
    }
    drawing_->faults.clear();
}

void RendererNode::send_counts(bus::Outbox& out) {
    schema::FrameCountsT counts;
    counts.frame = drawing_->plan.frame;
    counts.parts = std::move(drawing_->counts);
    out.send(bus::host_id, bus::pack(counts));
}

void RendererNode::send_pixels(bus::Outbox& out) {
    ++frames_;
    // If a send throws, the drawing must be gone: its messages can be finished only once.
    const std::unique_ptr<Drawing> drawn = std::move(drawing_);
    for (std::size_t i = 0; i < drawn->outputs.size(); ++i) {
        out.send(frame_buffers_[i],
                 drawn->outputs[i].finish(drawn->plan.frame, index_, drawn->plan.moved_mm));
    }
}

}  // namespace pxpl5::renderer
