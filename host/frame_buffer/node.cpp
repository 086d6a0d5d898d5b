#include "host/frame_buffer/node.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cassert>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "isa/contract/region_layout.hpp"
#include "ringbus/rules/views.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;
using bus::NodeFault;

/// The host keeps two frames going, one drawn while the next is prepared; as many again may have
/// been left incomplete by a fault elsewhere.
constexpr std::size_t max_in_flight = 4;
/// Messages of each Renderer that may wait for their BeginFrame.
constexpr std::size_t max_early = max_in_flight;

[[noreturn]] void throw_fault(schema::FaultCode code, const std::string& reason) {
    throw NodeFault(code, reason);
}

/// Ranges and sizes are the message's own business: it is verified.
FrameShape shape_of(const schema::DrawFrame& draw) {
    return {static_cast<int>(draw.width()), static_cast<int>(draw.height()),
            static_cast<int>(draw.views()->size())};
}

/// The Renderers of all regions of `frame`, by region.
std::vector<std::uint16_t> assignment_of(const schema::BeginFrame& begin, const Frame& frame,
                                         std::size_t renderer_count) {
    const auto& given = *begin.assignment();
    assert(given.size() == static_cast<std::size_t>(frame.whole.regions()));
    const auto outside = std::find_if(given.begin(), given.end(),
                                      [=](std::uint16_t r) { return r >= renderer_count; });
    if (outside != given.end()) {
        throw_fault(
            schema::FaultCode::bad_input,
            fmt::format("frame {}: region {} is assigned to Renderer {}, there are {}",
                        begin.draw()->frame(), outside - given.begin(), *outside, renderer_count));
    }
    std::vector<std::uint16_t> own(static_cast<std::size_t>(frame.shape.regions()));
    for (flatbuffers::uoffset_t region = 0; region < given.size(); ++region) {
        if (const auto place = frame.own_region(region)) {
            own[*place] = given[region];
        }
    }
    return own;
}

/// Throws unless the message holds each region that its Renderer draws in `frame` exactly once.
void check_tiles(const Frame& frame, const schema::RegionPixels& pixels) {
    const std::string from = fmt::format("frame {}, Renderer {}", frame.number, pixels.renderer());
    if (frame.renderer_is_in[pixels.renderer()]) {
        throw_fault(schema::FaultCode::bad_message, from + ": its regions came twice");
    }
    std::vector<bool> seen = frame.region_is_in;
    for (const schema::RegionTile* tile : *pixels.tiles()) {
        const std::size_t region = tile->region();
        if (region >= static_cast<std::size_t>(frame.whole.regions())) {
            throw_fault(schema::FaultCode::bad_message,
                        fmt::format("{}: region {}, the frame has {}", from, region,
                                    frame.whole.regions()));
        }
        const std::optional<std::size_t> own = frame.own_region(region);
        if (!own) {
            throw_fault(schema::FaultCode::bad_message,
                        fmt::format("{}: region {} belongs to a view of another frame buffer, this "
                                    "is {} of {}",
                                    from, region, frame.share.index, frame.share.frame_buffers));
        }
        if (frame.assignment[*own] != pixels.renderer()) {
            throw_fault(schema::FaultCode::bad_message,
                        fmt::format("{}: region {} is Renderer {}'s", from, region,
                                    frame.assignment[*own]));
        }
        if (seen[*own]) {
            throw_fault(schema::FaultCode::bad_message,
                        fmt::format("{}: region {} came twice", from, region));
        }
        seen[*own] = true;
    }
    const auto due =
        std::count(frame.assignment.begin(), frame.assignment.end(), pixels.renderer());
    if (pixels.tiles()->size() != static_cast<std::size_t>(due)) {
        throw_fault(schema::FaultCode::bad_message,
                    fmt::format("{}: {} regions, {} are assigned to it", from,
                                pixels.tiles()->size(), due));
    }
    if (due > 0 && frame.has_pixels == (pixels.pixels()->size() == 0)) {
        throw_fault(schema::FaultCode::bad_message,
                    fmt::format("{}: it sends {}pixels, the frame has {}", from,
                                frame.has_pixels ? "no " : "", frame.has_pixels ? "them" : "none"));
    }
    if (frame.read_depths != (pixels.depths() != nullptr)) {
        throw_fault(
            schema::FaultCode::bad_message,
            fmt::format("{}: it sends {}depths, the frame wants {}", from,
                        frame.read_depths ? "no " : "", frame.read_depths ? "them" : "none"));
    }
}

void take_tiles(Frame& frame, const schema::RegionPixels& pixels) {
    check_tiles(frame, pixels);
    const std::span<const std::uint32_t> words(pixels.pixels()->data(), pixels.pixels()->size());
    std::size_t at = 0, depths_at = 0;
    for (const schema::RegionTile* tile : *pixels.tiles()) {
        const std::size_t own = *frame.own_region(tile->region());
        const int region = static_cast<int>(own);
        frame.region_is_in[own] = true;
        frame.region_cycles[own] = tile->cycles();
        frame.instructions += tile->instructions();
        if (frame.read_back) {
            place_region(frame.shape, region, words.subspan(at, region_pixels), frame.picture);
        }
        if (tile->has_depths()) {
            place_depths(frame.shape, region, {pixels.depths()->data() + depths_at, region_pixels},
                         frame.depths);
            depths_at += region_pixels;
        } else if (frame.read_depths) {
            fill_region(frame.shape, region, isa::region::background_depth, frame.depths);
        }
        at += region_pixels;
    }
    frame.renderer_is_in[pixels.renderer()] = true;
    frame.moved_mm = std::max(frame.moved_mm, pixels.moved_mm());
}

/// Bytes of a FrameDone around its pixels and cycles.
constexpr std::size_t body_margin_bytes = 1024;

/// A frame at its beginning.
Frame begun(const schema::BeginFrame& begin, const ViewShare& share, std::size_t renderer_count) {
    Frame frame;
    frame.number = begin.draw()->frame();
    frame.shape = frame.whole = shape_of(*begin.draw());
    frame.shape.views =
        static_cast<int>(views_of(begin.draw()->views()->size(), share.index, share.frame_buffers));
    frame.share = share;
    frame.read_back = begin.draw()->read_back();
    frame.read_depths = begin.draw()->read_depths();
    frame.has_pixels = begin.draw()->sample() + 1 == begin.draw()->samples();
    frame.assignment = assignment_of(begin, frame, renderer_count);
    frame.renderer_is_in.resize(renderer_count);
    frame.region_is_in.resize(frame.assignment.size());
    frame.region_cycles.resize(frame.assignment.size());
    return frame;
}

/// The same frame, with room for its pictures in a message of `memory`.
FrameInFlight in_message(Frame frame, flatbuffers::Allocator* memory) {
    const std::size_t pixels = frame.shape.pixels();
    const std::size_t words = (frame.read_back ? pixels : 0) + (frame.read_depths ? pixels : 0);
    flatbuffers::FlatBufferBuilder body(
        words * sizeof(std::uint32_t) +
            frame.region_cycles.size() * (sizeof(std::uint64_t) + sizeof(std::uint16_t)) +
            body_margin_bytes,
        memory);
    // Every pixel is of a region that comes, so nothing need be cleared.
    const auto room = [&](std::span<std::uint32_t>& picture) {
        std::uint32_t* first = nullptr;
        const auto offset = body.CreateUninitializedVector<std::uint32_t>(pixels, &first);
        picture = {first, pixels};
        return FrameInFlight::Words(offset);
    };
    const FrameInFlight::Words picture = frame.read_back ? room(frame.picture) : 0;
    const FrameInFlight::Words depths = frame.read_depths ? room(frame.depths) : 0;
    return {std::move(frame), std::move(body), picture, depths};
}

bus::Payload frame_done(FrameInFlight& done) {
    const Frame& frame = done.frame;
    const auto cycles = done.body.CreateVector(frame.region_cycles);
    const auto renderers = done.body.CreateVector(frame.assignment);
    return bus::finish(
        done.body, schema::CreateFrameDone(
                       done.body, frame.number, static_cast<std::uint32_t>(frame.shape.width),
                       static_cast<std::uint32_t>(frame.shape.height),
                       static_cast<std::uint16_t>(frame.shape.views), cycles, frame.instructions,
                       done.picture, done.depths, renderers, frame.moved_mm));
}

}  // namespace

void FrameBufferNode::receive(const bus::Message& message, bus::Outbox& out) {
    if (message.kind() == schema::Body::Topology) {
        on_topology(message);
    } else if (const auto* begin = message.as<schema::BeginFrame>()) {
        on_begin_frame(*begin, out);
    } else if (message.kind() == schema::Body::RegionPixels) {
        on_region_pixels(message, out);
    } else {
        throw_fault(schema::FaultCode::bad_message,
                    fmt::format("a frame buffer does not take {}", bus::kind_name(message.kind())));
    }
}

bool FrameBufferNode::work(bus::Outbox&) {
    return false;
}

bus::NodeStatus FrameBufferNode::status() const {
    std::uint64_t bytes = 0;
    for (const FrameInFlight& each : in_flight_) {
        bytes += each.frame.picture.size_bytes() + each.frame.depths.size_bytes();
    }
    return {bytes, in_flight_.size(), frames_};
}

void FrameBufferNode::on_topology(const bus::Message& message) {
    std::vector<bus::NodeId> renderer_ids;
    ViewShare share{0, 0};
    bool found_self = false;
    for (const schema::NodeInfo* node : *message.as<schema::Topology>()->nodes()) {
        if (node->role() == schema::Role::frame_buffer) {
            ++share.frame_buffers;
            if (node->id() == message.header().destination()) {
                share.index = node->index();
                found_self = true;
            }
        } else if (node->role() == schema::Role::renderer) {
            renderer_ids.resize(std::max<std::size_t>(renderer_ids.size(), node->index() + 1U));
            renderer_ids[node->index()] = node->id();
        }
    }
    if (!found_self || share.index >= share.frame_buffers) {
        throw_fault(schema::FaultCode::bad_input,
                    fmt::format("topology: node {} is not one of the {} frame buffers",
                                message.header().destination(), share.frame_buffers));
    }
    renderer_ids_ = std::move(renderer_ids);
    share_ = share;
}

void FrameBufferNode::on_begin_frame(const schema::BeginFrame& begin, bus::Outbox& out) {
    const std::uint32_t number = begin.draw()->frame();
    if (number < next_frame_) {
        throw_fault(schema::FaultCode::bad_message,
                    fmt::format("frame {} begins after frame {}", number, next_frame_ - 1));
    }
    Frame frame = begun(begin, share_, renderer_ids_.size());
    if (frame.shape.views > 0) {  // Without a view, no message of this frame comes or goes.
        in_flight_.push_back(in_message(std::move(frame), out.body_allocator()));
    }
    next_frame_ = number + 1;
    give_up_before(in_flight_.size() > max_in_flight ? in_flight_[1].frame.number : 0);
    take_early(out);
}

/// Takes the regions that came before their frame began. Those of an older frame cannot be drawn
/// any more: the fault is that frame's, not the new one's.
void FrameBufferNode::take_early(bus::Outbox& out) {
    std::map<std::uint32_t, std::string> reasons;
    for (const bus::Message& message : std::exchange(early_, {})) {
        try {
            on_region_pixels(message, out);
        } catch (const NodeFault& fault) {  // The other Renderers' regions are taken all the same.
            std::string& text = reasons[message.as<schema::RegionPixels>()->frame()];
            text += (text.empty() ? "" : "; ") + std::string(fault.what());
        }
    }
    if (!reasons.empty()) {
        const auto& [oldest, text] = *reasons.begin();  // The host gives up all frames from it on.
        throw NodeFault(schema::FaultCode::bad_message, text, {schema::Body::RegionPixels, oldest});
    }
}

void FrameBufferNode::on_region_pixels(const bus::Message& message, bus::Outbox& out) {
    const auto& pixels = *message.as<schema::RegionPixels>();
    check_sender(message.source(), pixels);
    if (pixels.frame() >= next_frame_) {
        hold(message);
        return;
    }
    const auto found = std::find_if(in_flight_.begin(), in_flight_.end(), [&](const auto& f) {
        return f.frame.number == pixels.frame();
    });
    if (found == in_flight_.end()) {
        throw_fault(schema::FaultCode::bad_message,
                    fmt::format("frame {}, Renderer {}: its regions come late, the frame is over",
                                pixels.frame(), pixels.renderer()));
    }
    {
        const bus::StageClock::In assembling(out.clock(), stage::assemble);
        take_tiles(found->frame, pixels);
    }
    if (found->frame.complete()) {
        give_up_before(found->frame.number);
        swap_in(out);
    }
}

void FrameBufferNode::check_sender(bus::NodeId source, const schema::RegionPixels& pixels) const {
    if (pixels.renderer() >= renderer_ids_.size() || renderer_ids_[pixels.renderer()] != source) {
        throw_fault(schema::FaultCode::bad_message,
                    fmt::format("frame {}: node {} sends regions as Renderer {}, of {} Renderers",
                                pixels.frame(), source, pixels.renderer(), renderer_ids_.size()));
    }
}

void FrameBufferNode::hold(const bus::Message& message) {
    if (early_.size() >= max_early * renderer_ids_.size()) {
        const auto& pixels = *message.as<schema::RegionPixels>();
        throw_fault(
            schema::FaultCode::bad_message,
            fmt::format("frame {}, Renderer {}: the frame is unknown, and {} messages wait for "
                        "their frames already",
                        pixels.frame(), pixels.renderer(), early_.size()));
    }
    early_.push_back(message);
}

void FrameBufferNode::give_up_before(std::uint32_t number) {
    while (!in_flight_.empty() && in_flight_.front().frame.number < number) {
        const Frame& lost = in_flight_.front().frame;
        const auto missing =
            std::find(lost.renderer_is_in.begin(), lost.renderer_is_in.end(), false);
        // Whoever failed has sent its Fault; this is for the log.
        fmt::print(stderr, "frame {} is dropped: Renderer {} has not sent its regions\n",
                   lost.number, missing - lost.renderer_is_in.begin());
        in_flight_.pop_front();
    }
}

void FrameBufferNode::swap_in(bus::Outbox& out) {
    assert(in_flight_.front().frame.complete());
    // A send that throws must not leave it behind: its body can be finished but once.
    FrameInFlight done = std::move(in_flight_.front());
    in_flight_.pop_front();
    ++frames_;
    out.send(bus::host_id, frame_done(done));
}

}  // namespace pxpl5::host
