// The nodes of a session's machine: their activity, their traces, and their end.
#pragma once

#include <string>

#include "host/session/activity/activity.hpp"
#include "host/session/conversation.hpp"

namespace pxpl5::host {

/// Whether a question waits for nodes that are busy.
enum class AwaitAnswers : std::uint8_t { none, all };

class Nodes {
  public:
    explicit Nodes(Conversation& conversation);

    /// The work of the nodes since the last report. Without waiting, the answers to this question
    /// are part of the next report: busy nodes answer every 10 ms or so.
    ActivityReport activity(AwaitAnswers await);
    /// Counts a frame that arrived at the host.
    void count_frame() { activity_.count_frame(); }

    /// Counts from zero, with the nodes of a machine that has been started again.
    void begin_again() { activity_ = ActivityMonitor(conversation_.machine().nodes()); }

    /// Has every node write its trace. Throws RequestError if a node cannot.
    SavedTraces save_traces();

    /// Kills a node by its name. The next use of the machine throws MachineError.
    /// Throws RequestError for the host, an io process, and unknown names.
    void kill(const std::string& name);

  private:
    Conversation& conversation_;
    ActivityMonitor activity_;
};

}  // namespace pxpl5::host
