// What the machine's nodes do: their answers to AskActivity, and what is new in them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/machine/port.hpp"
#include "ringbus/message.hpp"
#include "ringbus/traffic.hpp"

namespace pxpl5::host {

/// What one node has done between its two newest answers.
struct NodeReport {
    MachineNode node;
    bool answered = false;  ///< Since the last report; else all counts are 0.
    double wall_ms = 0;     ///< Between the answers.
    double busy_ms = 0;     ///< Not waiting for messages. Of the host: as cpu_ms.
    double cpu_ms = 0;      ///< Processor time; less than busy_ms where cores are short.
    struct Stage {
        std::string name;
        double ms = 0;
        std::int64_t count = 0;
    };
    std::vector<Stage> stages;         ///< Those that took time; they add up to busy_ms.
    std::vector<bus::SentCount> sent;  ///< Without those of which there were none.
    std::uint64_t received_messages = 0, received_bytes = 0;
    std::int64_t frames = 0;

    // As things stood at the newest answer.
    std::uint64_t memory_bytes = 0;
    std::uint32_t queue = 0, held_up = 0;
};

struct ActivityReport {
    double wall_ms = 0;             ///< Since the last report, or the beginning.
    std::int64_t frames = 0;        ///< That came to the host in this time.
    std::vector<NodeReport> nodes;  ///< In ring order, the host first.
};

/// Keeps what each node has answered, and what it had answered when it was last reported. Whoever
/// owns it sends the questions.
class ActivityMonitor {
  public:
    explicit ActivityMonitor(std::vector<MachineNode> nodes);

    const std::vector<MachineNode>& nodes() const { return nodes_; }
    /// The nodes that owe no answer; from now on they do, so that a busy one has one question to
    /// answer and not a queue of them. Never the host.
    std::vector<bus::NodeId> ask();
    /// Whether a node owes an answer.
    bool awaits() const;
    void take(bus::NodeId from, const bus::schema::Activity& activity);
    void count_frame() { ++frames_; }

    /// What is new. own: what the host itself has sent and received so far.
    ActivityReport report(const bus::Traffic& own);

  private:
    struct Answers {
        bool owes = false;
        bool is_new = false;                          ///< `newest` has not been reported.
        bus::schema::ActivityT newest{}, reported{};  ///< All 0 until one came.
    };

    std::vector<MachineNode> nodes_;
    std::vector<Answers> answers_;  ///< One per entry of nodes_.
    std::int64_t frames_ = 0, reported_frames_ = 0;
    std::int64_t reported_ns_;  ///< Wall time of the last report.
};

}  // namespace pxpl5::host
