#include "host/timing/replay/hardware.hpp"

#include <algorithm>

namespace pxpl5::host::timing {

Snapshot snapshot(const Hardware& hardware) {
    const Ns now = hardware.events.now();
    Snapshot all{now, {hardware.mail.host().at(now), hardware.mail.link().at(now)}};
    for (const Processor& gp : hardware.gps) {
        all.busy.push_back(gp.busy().at(now));
    }
    for (const Meter& channel : hardware.ring.channels()) {
        all.busy.push_back(channel.at(now));
    }
    for (const UseMeter& renderer : hardware.renderers) {
        all.busy.push_back(renderer.at(now));
    }
    for (std::size_t port = 0; port < hardware.places.ports; ++port) {
        all.busy.push_back(hardware.ring.taken_at(hardware.places.port(port)).at(now));
    }
    return all;
}

std::vector<UnitUse> use_between(const Hardware& hardware, const Snapshot& begin,
                                 const Snapshot& end) {
    const auto time = static_cast<double>(std::max<Ns>(end.time - begin.time, 1));
    std::size_t at = 0;
    const auto of = [&](Unit unit, std::size_t count) {
        UnitUse use{unit};
        for (std::size_t i = 0; i < count; ++i, ++at) {
            const double share = static_cast<double>(end.busy[at] - begin.busy[at]) / time;
            use.mean += share / static_cast<double>(count);
            if (share > use.busiest) {
                use.busiest = share;
                use.index = static_cast<std::uint32_t>(i);
            }
        }
        return use;
    };
    // In the order of Snapshot::busy.
    return {of(Unit::host, 1),
            of(Unit::host_link, 1),
            of(Unit::gp, hardware.gps.size()),
            of(Unit::ring, hardware.ring.channels().size()),
            of(Unit::renderer, hardware.renderers.size()),
            of(Unit::frame_buffer, hardware.places.ports)};
}

}  // namespace pxpl5::host::timing
