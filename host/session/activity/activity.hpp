// The work of the machine's nodes: their answers to AskActivity, and the differences.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/machine/port.hpp"
#include "ringbus/message.hpp"
#include "ringbus/traffic.hpp"

namespace pxpl5::host {

/// The work of one node between its two newest answers.
struct NodeReport {
    MachineNode node;
    bool answered = false;  ///< False: no answer since the last report, and all counts are 0.
    double wall_ms = 0;     ///< Time between the answers.
    double busy_ms = 0;     ///< Time without waiting for messages. The host's is cpu_ms.
    double cpu_ms = 0;      ///< Processor time; less than busy_ms where cores are short.
    struct Stage {
        std::string name;
        double ms = 0;
        std::int64_t count = 0;
    };
    std::vector<Stage> stages = {};         ///< Stages that took time. Their sum is busy_ms.
    std::vector<bus::SentCount> sent = {};  ///< Kinds of messages that were sent.
    std::uint64_t received_messages = 0, received_bytes = 0;
    std::int64_t frames = 0;

    // Values at the newest answer.
    std::uint64_t memory_bytes = 0;
    std::uint32_t queue = 0, held_up = 0;
    std::uint64_t refused_messages = 0;  ///< Dropped since the start: no lawful sender.
};

struct ActivityReport {
    double wall_ms = 0;             ///< Time since the last report, or since the start.
    std::int64_t frames = 0;        ///< Frames that came to the host in this time.
    std::vector<NodeReport> nodes;  ///< In ring order, the host first.
};

/// Keeps each node's newest answer and its last reported answer. The owner sends the questions.
class ActivityMonitor {
  public:
    explicit ActivityMonitor(std::vector<MachineNode> nodes);

    const std::vector<MachineNode>& nodes() const { return nodes_; }
    /// Returns the nodes without an open question and marks them as asked. A busy node has at most
    /// one question to answer. Never the host.
    std::vector<bus::NodeId> ask();
    /// Whether a node has an open question.
    bool awaits() const;
    void take(bus::NodeId from, const bus::schema::Activity& activity);
    void count_frame() { ++frames_; }

    /// The differences since the last report. own: the host's traffic so far.
    ActivityReport report(const bus::Traffic& own);

  private:
    struct Answers {
        bool owes = false;
        bool is_new = false;                          ///< `newest` has not been reported.
        bus::schema::ActivityT newest{}, reported{};  ///< All 0 before the first answer.
    };

    std::vector<MachineNode> nodes_;
    std::vector<Answers> answers_;  ///< One per entry of nodes_.
    std::int64_t frames_ = 0, reported_frames_ = 0;
    std::int64_t reported_ns_;  ///< Wall time of the last report.
};

}  // namespace pxpl5::host
