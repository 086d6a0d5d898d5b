// A run of the simulated machine, recorded in memory: for tests of what reads recorded runs.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/inspect/record/recorded_run.hpp"
#include "host/session/session.hpp"
#include "tests/system/simulated_machine.hpp"

namespace pxpl5::test {

/// Every message that a node received, as its trace file would hold it.
class MemoryTraces {
  public:
    explicit MemoryTraces(const host::Topology& topology) {
        for (const host::RosterEntry& entry : host::roster_of(topology)) {
            Node& node = nodes_[entry.id];
            node.trace.info.node = entry.id;
            node.trace.info.role = entry.role;
            node.trace.info.index = static_cast<std::uint16_t>(entry.index);
            node.trace.info.build = "test";
            node.trace.info.schema_hash = bus::schema_hash();
        }
    }
    void note(bus::NodeId to, const bus::Message& message) {
        Node& node = nodes_.at(to);
        node.trace.entries.push_back({message.header(), ++wall_ns_, 0, node.messages->size()});
        node.messages->push_back(message);
    }
    std::vector<host::inspect::NodeTrace> traces() const {
        std::vector<host::inspect::NodeTrace> traces;
        for (const auto& [id, node] : nodes_) {
            traces.push_back(node.trace);
            traces.back().load = [messages = node.messages](const bus::trace::Entry& entry) {
                return messages->at(entry.offset);
            };
        }
        return traces;
    }

  private:
    struct Node {
        host::inspect::NodeTrace trace;
        std::shared_ptr<std::vector<bus::Message>> messages =
            std::make_shared<std::vector<bus::Message>>();
    };
    std::map<bus::NodeId, Node> nodes_;
    std::uint64_t wall_ns_ = 0;
};

/// A machine that records, with a session on it.
struct RecordedMachine {
    explicit RecordedMachine(host::Topology topology)
        : traces(topology),
          machine(recording(std::move(topology)), {},
                  [this](bus::NodeId to, const bus::Message& m) { traces.note(to, m); }),
          session(machine) {}

    host::inspect::RecordedRun run() const { return host::inspect::RecordedRun(traces.traces()); }

    MemoryTraces traces;
    SimulatedMachine machine;
    host::Session session;

  private:
    /// GPs say where primitives come from.
    static host::Topology recording(host::Topology topology) {
        topology.record = Recording::full;
        return topology;
    }
};

}  // namespace pxpl5::test
