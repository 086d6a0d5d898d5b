// What a session does with frames whose work is counted.
#include <algorithm>

#include "host/session/session.hpp"

namespace pxpl5::host {

namespace schema = bus::schema;

void Session::on_frame_counts(const bus::Message& message) {
    const auto& counts = *message.as<schema::FrameCounts>();
    const auto counted = std::ranges::find(counted_, counts.frame(), &CountedFrame::frame);
    if (counted != counted_.end()) {
        counts.UnPackTo(&counted->counts[message.source()]);
    }
}

/// Whether all that is to come of the frame has come.
bool Session::is_counted(const CountedFrame& frame) const {
    const auto has_told = [&](bus::NodeId node) { return frame.counts.contains(node); };
    return !frame.region_renderers.empty() && std::ranges::all_of(machine_.gp_ids(), has_told) &&
           std::ranges::all_of(machine_.renderer_ids(), has_told);
}

std::vector<CountedFrame> Session::draw_counted() {
    struct Forget {
        Session& session;
        ~Forget() { session.counted_.clear(); }
    };
    const Forget forget{*this};
    for (Pass pass{0, scene.samples}; pass.sample < scene.samples; ++pass.sample) {
        wait_for_frames(max_frames_in_flight - 1);
        CountedFrame& frame = counted_.emplace_back();
        frame.frame = next_frame_;
        frame.width = static_cast<std::uint32_t>(scene.size.width);
        frame.height = static_cast<std::uint32_t>(scene.size.height);
        frame.pass = pass;
        submit_frame(ReadBack::pixels, pass, true);
    }
    wait_for_frames(0);
    take_frame();
    wait("counts of the frame", [this] {
        return fault_.has_value() || std::ranges::all_of(counted_, [this](const CountedFrame& f) {
                   return is_counted(f);
               });
    });
    return std::move(counted_);
}

}  // namespace pxpl5::host
