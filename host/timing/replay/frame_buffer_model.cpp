#include "host/timing/replay/frame_buffer_model.hpp"

#include <algorithm>

#include "ringbus/rules/views.hpp"

namespace pxpl5::host::timing {

namespace {
constexpr std::uint64_t frame_done_words = 4;
}

Place FrameBufferModel::port_of(std::uint32_t frame, std::uint32_t region) const {
    const std::uint32_t buffers = hardware_.machine.frame_buffers;
    const std::size_t ports = hardware_.places.ports / buffers;
    const std::size_t buffer = frame_buffer_of(frames_[frame].plan->region(region).view, buffers);
    return hardware_.places.port(buffer * ports + region % ports);
}

void FrameBufferModel::region_in(std::uint32_t frame) {
    FrameRun& run = frames_[frame];
    if (--run.regions_due > 0) {
        return;
    }
    run.complete();
    const Ns now = hardware_.events.now();
    hardware_.events.at(run.plan->reads_out() ? hardware_.costs.retrace(now) : now,
                        [this, frame] { swap(frame); });
}

void FrameBufferModel::swap(std::uint32_t frame) {
    FrameRun& run = frames_[frame];
    run.shown();
    for (std::size_t port = 0; port < hardware_.places.ports; ++port) {
        hardware_.ring.open(hardware_.places.port(port), frame + 1);
    }
    const std::size_t buffers = hardware_.machine.frame_buffers;
    run.reports_due = std::min(run.plan->views(), buffers);
    for (std::size_t buffer = 0, due = run.reports_due; buffer < due; ++buffer) {
        hardware_.mail.send(hardware_.places.port(buffer * (hardware_.places.ports / buffers)),
                            hardware_.places.host(), frame_done_words,
                            [this, frame] { report_in(frame); });
    }
}

void FrameBufferModel::report_in(std::uint32_t frame) {
    FrameRun& run = frames_[frame];
    if (--run.reports_due == 0) {
        run.plan.reset();
        run.known();
    }
}

}  // namespace pxpl5::host::timing
