#include "host/timing/headset.hpp"

#include <array>
#include <cassert>

namespace pxpl5::host::timing {

namespace {

constexpr std::array rows = {
#define PXPL5_HEADSET(field, name, unit, value, provenance, source) \
    HeadsetRow{name, unit, &Headset::field, Provenance::provenance, source},
#include "host/timing/headset.def"
};

}  // namespace

std::span<const HeadsetRow> headset_rows() {
    return rows;
}

Machine headset_machine(const Machine& machine, const Headset& headset) {
    Machine changed = machine;
    changed.frame_buffers = static_cast<std::uint32_t>(headset.frame_buffers);
    changed.frame_buffer_refresh_hz = headset.field_hz;
    return changed;
}

HeadsetTime headset_time(const Machine& machine, const Headset& headset, const FrameWork& pair) {
    assert(pair.views == 2);
    constexpr double ns_per_ms = 1e6;
    HeadsetTime time;
    time.rate = frame_rate(headset_machine(machine, headset), pair);
    time.drawn_ms = static_cast<double>(time.rate.drawn) / ns_per_ms;
    const double shown_ms = time.drawn_ms + headset.wait_ms() + headset.scan_out_ms();
    time.least_ms = headset.tracker_least_ms + shown_ms;
    time.most_ms = headset.tracker_most_ms + shown_ms;
    return time;
}

}  // namespace pxpl5::host::timing
