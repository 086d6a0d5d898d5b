#include "host/timing/replay/renderer_model.hpp"

#include <algorithm>
#include <cassert>

#include "host/timing/replay/deal.hpp"

namespace pxpl5::host::timing {

void RendererModel::add(std::uint32_t frame, std::uint32_t region) {
    Draw draw;
    draw.frame = frame;
    draw.region = region;
    draw.doors_paid.resize(frames_[frame].plan->region(region).doors.size());
    draws_.push_back(std::move(draw));
    prepare(draws_.back());
    bring();
    go_on();
}

void RendererModel::gp_ready() {
    for (Draw& draw : draws_) {
        prepare(draw);
    }
    bring();
    go_on();
}

// The software of sending runs as soon as the Renderer is known and the bin is complete.
void RendererModel::prepare(Draw& draw) {
    if (draw.complete) {
        return;
    }
    const FrameRun& run = frames_[draw.frame];
    while (draw.sendable.size() < run.ready.size()) {
        const std::uint16_t gp = run.ready[draw.sendable.size()];
        const bool empty = run.plan->bin(draw.region, gp).words == 0;
        draw.sendable.push_back(empty ? 0
                                      : hardware_.gps[gp].message(hardware_.costs.gp_message()));
    }
}

void RendererModel::bring() {
    while (!bin_comes_ && brings_ - first_ < draws_.size()) {
        Draw& next = draw(brings_);
        const FrameRun& run = frames_[next.frame];
        if (next.looked_at < run.ready.size()) {
            const std::uint16_t gp = run.ready[next.looked_at];
            const Ns time = std::max(next.sendable[next.looked_at++], hardware_.events.now());
            if (run.plan->bin(next.region, gp).words > 0) {
                bin_comes_ = true;
                hardware_.events.at(time, [this, number = brings_, gp] { send_bin(number, gp); });
            }
        } else if (run.ready.size() == hardware_.gps.size()) {
            next.complete = true;
            ++brings_;
        } else {
            return;
        }
    }
}

void RendererModel::send_bin(std::uint32_t number, std::uint16_t gp) {
    Draw& of = draw(number);
    RingMessage message;
    message.source = hardware_.places.gp(gp);
    message.destination = hardware_.places.renderer(index_);
    message.words = frames_[of.frame].plan->bin(of.region, gp).words;
    message.stays = true;
    message.arrives = [this, number, gp](Packet packet) { arrive(number, gp, packet); };
    message.left = [this] {
        bin_comes_ = false;
        bring();
        go_on();
    };
    of.words_due += message.words;
    hardware_.ring.send(message);
}

void RendererModel::arrive(std::uint32_t number, std::uint16_t gp, Packet packet) {
    fifo_.push_back({number, packet.words, work_of(draw(number), gp, packet)});
    go_on();
}

// A bin's cycles in proportion to words; a surface's own parts with its first packet.
Ns RendererModel::work_of(Draw& draw, std::uint16_t gp, Packet packet) const {
    const FramePlan& plan = *frames_[draw.frame].plan;
    const Bin& bin = plan.bin(draw.region, gp);
    const std::uint64_t end = packet.offset + packet.words;
    Ns time = hardware_.costs.renderer(Deal::part(bin.cycles, end, bin.words) -
                                       Deal::part(bin.cycles, packet.offset, bin.words));
    for (const DoorPlace& place : plan.doors_of(draw.region, gp)) {
        if (place.word >= packet.offset && place.word < end && !draw.doors_paid[place.door]) {
            draw.doors_paid[place.door] = true;
            time += plan.region(draw.region).doors[place.door].time;
        }
    }
    return time;
}

void RendererModel::go_on() {
    if (doing_ != Doing::nothing || draws_.empty()) {
        return;
    }
    Draw& now = draws_.front();
    const RegionPlan& region = frames_[now.frame].plan->region(now.region);
    if (!now.begun) {
        now.begun = true;
        start(Doing::prologue, region.prologue);
    } else if (!fifo_.empty() && fifo_.front().draw == first_) {
        start(Doing::packet, fifo_.front().time);
    } else if (now.complete && now.words_due == 0) {
        asks_();
        start(Doing::end, region.end);
    }
}

void RendererModel::start(Doing doing, Ns time) {
    doing_ = doing;
    use().begin(hardware_.events.now());
    hardware_.events.at(hardware_.events.now() + time, [this] { finish(); });
}

void RendererModel::finish() {
    use().end(hardware_.events.now());
    const Doing done = doing_;
    doing_ = Doing::nothing;
    if (done == Doing::packet) {
        const std::uint32_t words = fifo_.front().words;
        fifo_.pop_front();
        assert(draws_.front().words_due >= words);
        draws_.front().words_due -= words;
        hardware_.ring.release(hardware_.places.renderer(index_), words);
    } else if (done == Doing::end && reads_out_) {
        doing_ = Doing::stalled;
    } else if (done == Doing::end) {
        leave();
    }
    go_on();
}

// The region goes to the port, and the array on to the next.
void RendererModel::leave() {
    assert(draws_.front().complete);
    const std::uint32_t frame = draws_.front().frame, region = draws_.front().region;
    draws_.pop_front();
    ++first_;
    reads_out_ = true;
    const Ns now = hardware_.events.now();
    use().begin(now);
    hardware_.events.at(now + frames_[frame].plan->region(region).port,
                        [this, frame, region] { send_pixels(frame, region); });
}

void RendererModel::send_pixels(std::uint32_t frame, std::uint32_t region) {
    use().end(hardware_.events.now());
    RingMessage message;
    message.source = hardware_.places.renderer(index_);
    message.destination = buffers_.port_of(frame, region);
    message.words = frames_[frame].plan->region(region).pixel_words;
    message.gate = frame;
    message.arrives = [this, frame](Packet packet) {
        if (packet.last) {
            buffers_.region_in(frame);
        }
    };
    message.left = [this] { readout_over(); };
    hardware_.ring.send(message);
}

void RendererModel::readout_over() {
    reads_out_ = false;
    if (doing_ == Doing::stalled) {
        doing_ = Doing::nothing;
        leave();
        go_on();
    }
}

}  // namespace pxpl5::host::timing
