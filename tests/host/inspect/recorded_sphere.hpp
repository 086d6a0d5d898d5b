// A recorded frame of a sphere, and recordings changed after the fact.
#pragma once

#include <cstring>

#include "tests/host/inspect/recorded_machine.hpp"

namespace pxpl5::test {

inline host::Topology machine_of(int gps, int renderers) {
    host::Topology topology;
    topology.gp.count = gps;
    topology.renderer.count = renderers;
    topology.frame_buffer.count = 1;
    return topology;
}

inline void set_up_sphere(host::Session& session, host::Size size) {
    session.scene.size = size;
    session.volumes.load("phantom:sphere");
    session.surfaces.set("ball", 100, CaseRule::watertight, {200, 100, 50});
}

/// One frame of a sphere, drawn by a simulated machine that is gone.
class TracedSphere {
  public:
    TracedSphere(host::Size size, int gps, int renderers) {
        RecordedMachine recorded(machine_of(gps, renderers));
        set_up_sphere(recorded.session, size);
        picture = recorded.session.frames.draw();
        traces_ = recorded.traces.traces();
    }
    std::vector<host::inspect::NodeTrace> traces() const { return traces_; }
    host::inspect::RecordedRun run() const { return host::inspect::RecordedRun(traces_); }

    host::Picture picture;

  private:
    std::vector<host::inspect::NodeTrace> traces_;
};

/// The message with another body.
inline bus::Message with_body(const bus::Message& message, const bus::Payload& payload) {
    const bus::schema::Header& h = message.header();
    const bus::schema::Header header(
        h.magic(), h.version(), h.kind(), h.source(), h.destination(), h.channel(), h.reserved(),
        h.sequence(), payload.bytes().size(), h.departure_ns(), h.arrival_ns(), h.clock());
    // Messages lie at multiples of 8 bytes.
    const auto words =
        std::make_shared<std::vector<std::uint64_t>>((payload.bytes().size() + 7) / 8);
    std::memcpy(words->data(), payload.bytes().data(), payload.bytes().size());
    return {header,
            {reinterpret_cast<const std::uint8_t*>(words->data()), payload.bytes().size()},
            words};
}

/// Hands every recorded message of table T to edit(T's object, node), which may change it.
template <typename T, typename Edit>
void change(std::vector<host::inspect::NodeTrace>& traces, const Edit& edit) {
    for (host::inspect::NodeTrace& node : traces) {
        auto changed = std::make_shared<std::vector<bus::Message>>();
        for (bus::trace::Entry& entry : node.entries) {
            const bus::Message message = node.load(entry);
            entry.offset = changed->size();
            if (const T* table = message.as<T>()) {
                typename T::NativeTableType object;
                table->UnPackTo(&object);
                edit(object);
                changed->push_back(with_body(message, bus::pack(object)));
            } else {
                changed->push_back(message);
            }
        }
        node.load = [changed](const bus::trace::Entry& entry) { return changed->at(entry.offset); };
    }
}

}  // namespace pxpl5::test
