#include "host/inspect/record/recorded_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "host/base/error.hpp"
#include "host/inspect/record/recorded_results.hpp"
#include "isa/contract/region_layout.hpp"
#include "isa/contract/sample_sums.hpp"
#include "ringbus/rules/regions.hpp"
#include "ringbus/rules/voxels.hpp"
#include "ringbus/trace/trace_info.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace schema = bus::schema;
using bus::Body;

constexpr std::size_t frames_named = 8;  ///< In an error; then the last one.

int regions_along(std::uint32_t length_px) {
    return static_cast<int>(regions_across(length_px));
}

/// "3, 4, 5", the middle of a long list left out.
std::string list_of(const std::vector<std::uint32_t>& frames) {
    std::string text;
    for (std::size_t i = 0; i < frames.size(); ++i) {
        if (i < frames_named || i + 1 == frames.size()) {
            text += fmt::format("{}{}", i == 0 ? "" : ", ", frames[i]);
        } else if (i == frames_named) {
            text += ", ...";
        }
    }
    return frames.empty() ? "none" : text;
}

/// Why the sums to which a Renderer's regions are added are not known; empty if they are, or if
/// there are none.
std::string missing_sums(const RecordedFrame& frame, std::uint32_t renderer,
                         const renderer::FramePlan& plan) {
    const std::uint32_t sample = plan.pass.sample;
    const auto is_known = [&](const renderer::FramePlan::Region& region) {
        const auto found = frame.earlier->regions.find(region.number);
        return found != frame.earlier->regions.end() && found->second.renderer == renderer;
    };
    if (sample == 0 || (frame.earlier && std::ranges::all_of(plan.regions, is_known))) {
        return {};
    }
    return fmt::format(
        "renderer-{}: {} adds to the sums of frames {} to {}, not all of which are recorded",
        renderer, frame.pass_text(), frame.number - sample, frame.number - 1);
}

/// True if a Renderer was sent the frame that the others were sent: the same regions, at the same
/// Renderers, of the same surfaces.
bool is_same_frame(const schema::BeginFrame& a, const schema::BeginFrame& b) {
    const schema::DrawFrame &p = *a.draw(), &q = *b.draw();
    return p.width() == q.width() && p.height() == q.height() &&
           p.views()->size() == q.views()->size() && p.surfaces()->size() == q.surfaces()->size() &&
           p.sample() == q.sample() && p.samples() == q.samples() &&
           std::ranges::equal(*a.assignment(), *b.assignment());
}

/// Returns why the Renderer's regions cannot be put together; empty if they can.
std::string missing_regions(const RecordedFrame& frame, std::uint32_t renderer,
                            const renderer::FrameMessages& inputs) {
    const auto& whole = *frame.begin->as<schema::BeginFrame>();
    const auto& its = *inputs.begin->as<schema::BeginFrame>();
    if (!is_same_frame(whole, its)) {
        return fmt::format("renderer-{}: its BeginFrame differs from that of another node",
                           renderer);
    }
    const auto ours = static_cast<std::size_t>(std::ranges::count(*its.assignment(), renderer));
    const std::size_t most = isa::max_summed_regions(its.draw()->samples());
    if (its.draw()->samples() > 1 && ours > most) {
        return fmt::format("renderer-{}: {} regions of {} samples, but sums fit for {}", renderer,
                           ours, its.draw()->samples(), most);
    }
    return {};
}

/// The region that has `slot` at its Renderer, behind the passes before.
void add_region(RecordedFrame& frame, std::uint32_t renderer, const renderer::FramePlan& plan,
                std::size_t slot) {
    const renderer::FramePlan::Region& planned = plan.regions[slot];
    RecordedRegion& region = frame.regions[planned.number];
    region.place = frame.place(planned.number);
    region.renderer = renderer;
    renderer::RegionFrame programs = renderer::region_frame(plan.programs);
    if (plan.pass.samples > 1) {
        region.end_of_region =
            renderer::at_slot(plan.programs.end_of_region, plan.pass.samples, slot);
        programs.end_of_region = region.end_of_region;
        programs.holds_sums = true;
    }
    region.plan = renderer::plan_region(programs, planned.segments);
    if (plan.pass.sample > 0) {
        const RecordedRegion& earlier = frame.earlier->regions.at(planned.number);
        region.before.parts = earlier.before.parts;
        region.before.parts.insert(region.before.parts.end(), earlier.plan.parts.begin(),
                                   earlier.plan.parts.end());
    }
}

}  // namespace

std::string RecordedFrame::pass_text() const {
    return draw().samples() == 1
               ? std::string()
               : fmt::format("sample {} of {}", draw().sample() + 1, draw().samples());
}

RegionPlace RecordedFrame::place(std::uint32_t region) const {
    const int columns = regions_along(draw().width()), rows = regions_along(draw().height());
    const int at = static_cast<int>(region);
    RegionPlace place;
    place.number = region;
    place.view = at / (columns * rows);
    place.row = at % (columns * rows) / columns;
    place.column = at % columns;
    place.x0_px = place.column * region_px;
    place.y0_px = place.view * static_cast<int>(draw().height()) + place.row * region_px;
    return place;
}

RegionPlace RecordedFrame::region_at(int x, int y) const {
    const int width = static_cast<int>(draw().width()), height = static_cast<int>(draw().height());
    const int views = static_cast<int>(draw().views()->size());
    if (x < 0 || x >= width || y < 0 || y >= height * views) {
        throw RequestError(
            ExitCode::usage,
            fmt::format("pixel ({}, {}) is outside of frame {}, which has {} x {} pixels", x, y,
                        number, width, height * views));
    }
    const int columns = regions_along(draw().width()), rows = regions_along(draw().height());
    const int view = y / height, row = y % height / region_px;
    return place(static_cast<std::uint32_t>((view * rows + row) * columns + x / region_px));
}

RecordedRun::RecordedRun(std::vector<NodeTrace> nodes) {
    for (NodeTrace& node : nodes) {
        roles_[node.info.node] = {node.info.role, node.info.index};
        nodes_.insert_or_assign(bus::NodeId{node.info.node}, std::move(node));
    }
    for (const auto& [id, node] : nodes_) {
        index_node(id, node);
    }
    if (gp_count_ == 0 || renderer_count_ == 0) {
        std::string text = fmt::format("none of {} traces describes the machine", nodes_.size());
        for (const auto& [id, node] : nodes_) {
            text += node.cut.empty() ? "" : "; " + node_name(id) + ": " + node.cut;
        }
        throw RequestError(ExitCode::bad_data, text);
    }
}

void RecordedRun::index_node(bus::NodeId id, const NodeTrace& node) {
    for (std::size_t i = 0; i < node.entries.size(); ++i) {
        switch (node.entries[i].kind()) {
            case Body::Topology:
            case Body::BeginFrame:
            case Body::RegionPrograms:
            case Body::RegionPixels:
            case Body::FrameDone:
                index_entry({id, i}, node.load(node.entries[i]));
                break;
            default:
                break;  // Found by kind when it is asked for.
        }
    }
}

void RecordedRun::index_entry(FrameIndex::At at, const bus::Message& message) {
    const std::uint32_t node = index_of(at.node);
    const bool at_renderer = roles_[at.node].first == schema::Role::renderer;
    if (const auto* topology = message.as<schema::Topology>()) {
        gp_count_ = renderer_count_ = frame_buffer_count_ = 0;
        for (const schema::NodeInfo* info : *topology->nodes()) {
            roles_[info->id()] = {info->role(), info->index()};
            gp_count_ += info->role() == schema::Role::gp ? 1 : 0;
            renderer_count_ += info->role() == schema::Role::renderer ? 1 : 0;
            frame_buffer_count_ += info->role() == schema::Role::frame_buffer ? 1 : 0;
        }
    } else if (const auto* begin = message.as<schema::BeginFrame>()) {
        FrameIndex& frame = frames_[begin->draw()->frame()];
        if (at_renderer) {
            frame.begins[node] = at;
        }
        frame.begin = at;
    } else if (const auto* programs = message.as<schema::RegionPrograms>()) {
        frames_[programs->frame()].programs[node][programs->gp()] = at;
    } else if (const auto* pixels = message.as<schema::RegionPixels>()) {
        frames_[pixels->frame()].pixels.emplace(pixels->renderer(), at);
    } else if (const auto* done = message.as<schema::FrameDone>()) {
        frames_[done->frame()].done[message.source()] = at;
    }
}

std::uint32_t RecordedRun::index_of(bus::NodeId id) const {
    const auto found = roles_.find(id);
    return found == roles_.end() ? 0 : found->second.second;
}

const NodeTrace* RecordedRun::find(schema::Role role, std::uint32_t index) const {
    for (const auto& [id, node] : nodes_) {
        if (node.info.role == role && node.info.index == index) {
            return &node;
        }
    }
    return nullptr;
}

std::string RecordedRun::node_name(bus::NodeId id) const {
    const auto found = roles_.find(id);
    if (found == roles_.end()) {
        return fmt::format("node-{}", id);
    }
    return bus::trace::name_of(found->second.first,
                               static_cast<std::uint16_t>(found->second.second));
}

std::vector<std::uint32_t> RecordedRun::frames() const {
    std::vector<std::uint32_t> numbers;
    for (const auto& [number, frame] : frames_) {
        if (frame.begin) {
            numbers.push_back(number);
        }
    }
    return numbers;
}

bus::Message RecordedRun::load(FrameIndex::At at) const {
    const NodeTrace& node = nodes_.at(at.node);
    return node.load(node.entries[at.entry]);
}

RecordedFrame RecordedRun::frame(std::uint32_t number) const {
    const auto found = frames_.find(number);
    if (found == frames_.end() || !found->second.begin) {
        throw RequestError(ExitCode::usage, fmt::format("frame {} is not in this run; it has {}",
                                                        number, list_of(frames())));
    }
    const FrameIndex& index = found->second;
    RecordedFrame frame;
    frame.number = number;
    frame.begin = load(*index.begin);
    for (const auto& [frame_buffer, at] : index.done) {
        frame.done.push_back(load(at));
    }
    frame.joined = joined_picture(frame);
    add_earlier(frame);
    for (const auto& [renderer, at] : index.pixels) {
        frame.pixels.emplace(renderer, load(at));
    }
    for (std::uint32_t renderer = 0; renderer < renderer_count_; ++renderer) {
        const auto programs = index.programs.find(renderer);
        const std::size_t came = programs == index.programs.end() ? 0 : programs->second.size();
        if (index.begins.count(renderer) == 0 || came < gp_count_) {
            frame.missing.push_back(
                fmt::format("renderer-{}: {} recorded, programs of {} of {} GPs", renderer,
                            index.begins.count(renderer) == 0 ? "no BeginFrame" : "BeginFrame",
                            came, gp_count_));
            continue;
        }
        renderer::FrameMessages& inputs = frame.inputs[renderer];
        inputs.begin = load(index.begins.at(renderer));
        for (const auto& [gp, at] : programs->second) {
            inputs.programs.emplace(gp, load(at));
        }
        if (std::string missing = missing_regions(frame, renderer, inputs); !missing.empty()) {
            frame.missing.push_back(std::move(missing));
            frame.inputs.erase(renderer);
            continue;
        }
        renderer::FramePlan& plan = frame.plans[renderer];
        plan = renderer::plan_frame(inputs, renderer);
        if (const std::string missing = missing_sums(frame, renderer, plan); !missing.empty()) {
            frame.missing.push_back(missing);
            continue;
        }
        for (std::size_t slot = 0; slot < plan.regions.size(); ++slot) {
            add_region(frame, renderer, plan, slot);
        }
    }
    return frame;
}

/// Adds the frame before a pass, if that frame is the pass before it. Each step lowers the sample,
/// so that at most 15 frames are added.
void RecordedRun::add_earlier(RecordedFrame& frame) const {
    const schema::DrawFrame& draw = frame.draw();
    const auto found = frames_.find(frame.number - 1);
    if (draw.sample() == 0 || found == frames_.end() || !found->second.begin) {
        return;
    }
    const bus::Message begin = load(*found->second.begin);
    const schema::DrawFrame& before = *begin.as<schema::BeginFrame>()->draw();
    if (before.samples() == draw.samples() && before.sample() + 1 == draw.sample()) {
        frame.earlier = std::make_unique<RecordedFrame>(this->frame(frame.number - 1));
    }
}

std::optional<RecordedVolume> RecordedRun::volume(std::uint32_t frame) const {
    // The newest header that GP 0 had when the frame was asked for.
    const NodeTrace* master = find(schema::Role::gp, 0);
    if (master == nullptr) {
        return std::nullopt;
    }
    std::optional<bus::Message> header;
    for (const bus::trace::Entry& entry : master->entries) {
        if (entry.kind() == Body::VolumeHeader) {
            header = master->load(entry);
        } else if (entry.kind() == Body::SceneBegin) {
            header.reset();  // An archive took the volume's place.
        } else if (entry.kind() == Body::DrawFrame &&
                   master->load(entry).as<schema::DrawFrame>()->frame() == frame) {
            break;
        }
    }
    return header ? std::optional(volume_of(*header)) : std::nullopt;
}

RecordedVolume RecordedRun::volume_of(const bus::Message& header) const {
    const auto& shape = *header.as<schema::VolumeHeader>();
    RecordedVolume volume{header, {}, std::vector<const std::uint8_t*>(shape.nz(), nullptr)};
    const std::size_t due = std::size_t{shape.nx()} * shape.ny() * size_bytes(shape.type());
    for (const auto& [id, node] : nodes_) {
        for (const bus::trace::Entry& entry : node.entries) {
            if (entry.kind() != Body::Slices) {
                continue;
            }
            const bus::Message message = node.load(entry);
            const auto& slices = *message.as<schema::Slices>();
            const std::size_t size = slices.values()->size() / slices.slice_count();
            if (slices.volume() != shape.volume() || size != due) {
                continue;
            }
            for (std::uint32_t n = 0; n < slices.slice_count(); ++n) {
                if (slices.first_slice() + n < shape.nz()) {
                    volume.slice[slices.first_slice() + n] = slices.values()->data() + n * size;
                }
            }
            volume.slices.push_back(message);
        }
    }
    return volume;
}

std::optional<bus::Message> RecordedRun::surface(std::uint16_t surface,
                                                 std::uint32_t revision) const {
    for (const auto& [id, node] : nodes_) {
        for (const bus::trace::Entry& entry : node.entries) {
            if (entry.kind() != Body::SetSurface) {
                continue;
            }
            bus::Message message = node.load(entry);
            const auto& set = *message.as<schema::SetSurface>();
            if (set.surface() == surface && set.revision() == revision) {
                return message;
            }
        }
    }
    return std::nullopt;
}

std::optional<double> RecordedVolume::value(int x, int y, int z) const {
    const auto& shape = *header.as<schema::VolumeHeader>();
    const auto is_below = [](int at, std::uint32_t count) {
        return at >= 0 && static_cast<std::uint32_t>(at) < count;
    };
    if (!is_below(x, shape.nx()) || !is_below(y, shape.ny()) || !is_below(z, shape.nz()) ||
        slice[static_cast<std::size_t>(z)] == nullptr) {
        return std::nullopt;
    }
    const std::uint8_t* values = slice[static_cast<std::size_t>(z)];
    const std::size_t voxel =
        static_cast<std::size_t>(y) * shape.nx() + static_cast<std::size_t>(x);
    const auto read = [&]<typename T>(T one) -> double {
        std::memcpy(&one, values + voxel * sizeof one, sizeof one);
        return static_cast<double>(one);
    };
    switch (shape.type()) {
        case Scalar::uint8:
            return read(std::uint8_t{});
        case Scalar::int16:
            return read(std::int16_t{});
        case Scalar::uint16:
            return read(std::uint16_t{});
        case Scalar::float32:
            return read(float{});
    }
    return std::nullopt;
}

}  // namespace pxpl5::host::inspect
