#include "host/timing/replay/frame_model.hpp"

namespace pxpl5::host::timing {

namespace {
constexpr std::uint64_t draw_frame_words = 64, begin_frame_words = 64, region_words = 2;
}

FrameModel::FrameModel(Hardware& hardware) : hardware_(hardware), buffers_(hardware, frames_) {
    for (std::uint32_t i = 0; i < hardware.machine.renderers; ++i) {
        const auto renderer = static_cast<std::uint16_t>(i);
        renderers_.emplace_back(hardware, frames_, buffers_, renderer,
                                [this, renderer] { ask(renderer); });
        wants_region_.push_back(renderer);
    }
}

void FrameModel::draw(FrameRun frame) {
    const auto number = static_cast<std::uint32_t>(frames_.size());
    frame.regions = frame.regions_due = frame.plan->regions();
    frames_.push_back(std::move(frame));
    hardware_.mail.send(hardware_.places.host(), hardware_.places.gp(0), draw_frame_words,
                        [this, number] { begin(number); });
}

void FrameModel::begin(std::uint32_t frame) {
    const double cycles =
        static_cast<double>(frames_[frame].regions) * hardware_.machine.master_region_cycles;
    hardware_.events.at(hardware_.gps[0].message(hardware_.costs.gp(cycles)),
                        [this, frame] { broadcast(frame); });
}

void FrameModel::broadcast(std::uint32_t frame) {
    const Places& places = hardware_.places;
    for (std::uint16_t gp = 1; gp < places.gps; ++gp) {
        hardware_.mail.send(places.gp(0), places.gp(gp), begin_frame_words,
                            [this, frame, gp] { gp_begins(frame, gp); });
    }
    for (std::uint16_t renderer = 0; renderer < places.renderers; ++renderer) {
        hardware_.mail.send(places.gp(0), places.renderer(renderer), begin_frame_words,
                            [this, frame, renderer] { renderer_begins(frame, renderer); });
    }
    const std::uint32_t buffers = hardware_.machine.frame_buffers;
    for (std::uint32_t buffer = 0; buffer < buffers; ++buffer) {
        hardware_.mail.send(places.gp(0), places.port(buffer * (places.ports / buffers)),
                            begin_frame_words, [] {});
    }
    gp_begins(frame, 0);
    begun_ = frame + 1;
    if (hands_out()) {
        hand_out();
    }
}

void FrameModel::gp_begins(std::uint32_t frame, std::uint16_t gp) {
    hardware_.gps[gp].work(frames_[frame].plan->draw_time(gp),
                           [this, frame, gp] { gp_ready(frame, gp); });
}

void FrameModel::gp_ready(std::uint32_t frame, std::uint16_t gp) {
    frames_[frame].ready.push_back(gp);
    for (RendererModel& renderer : renderers_) {
        renderer.gp_ready();
    }
}

void FrameModel::renderer_begins(std::uint32_t frame, std::uint16_t renderer) {
    const std::vector<std::uint16_t>& assignment = frames_[frame].assignment;
    for (std::uint32_t region = 0; region < assignment.size(); ++region) {
        if (assignment[region] == renderer) {
            renderers_[renderer].add(frame, region);
        }
    }
}

void FrameModel::ask(std::uint16_t renderer) {
    if (hands_out()) {
        hardware_.mail.send(hardware_.places.renderer(renderer), hardware_.places.gp(0),
                            region_words, [this, renderer] {
                                wants_region_.push_back(renderer);
                                hand_out();
                            });
    }
}

void FrameModel::hand_out() {
    while (!wants_region_.empty() && next_frame_ < begun_) {
        if (next_region_ == frames_[next_frame_].regions) {
            ++next_frame_;
            next_region_ = 0;
            continue;
        }
        assign(wants_region_.front(), next_frame_, frames_[next_frame_].order[next_region_++]);
        wants_region_.pop_front();
    }
}

void FrameModel::assign(std::uint16_t renderer, std::uint32_t frame, std::uint32_t region) {
    const Ns decided =
        hardware_.gps[0].message(hardware_.costs.gp(hardware_.machine.master_region_cycles));
    hardware_.events.at(decided, [this, renderer, frame, region] {
        hardware_.mail.send(
            hardware_.places.gp(0), hardware_.places.renderer(renderer), region_words,
            [this, renderer, frame, region] { renderers_[renderer].add(frame, region); });
    });
}

}  // namespace pxpl5::host::timing
