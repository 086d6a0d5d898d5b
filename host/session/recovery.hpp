// Keeps a session going when nodes of its machine die or hang.
//
//   run(act) --> act --> MachineError --> start the machine --> restore the scene --> act again
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "host/machine/port.hpp"
#include "host/scene/scene.hpp"

namespace pxpl5::host {

struct Session;

/// The machine was started again, but cannot have its content. Nothing is loaded.
struct ContentLost : RequestError {
    using RequestError::RequestError;
};

/// A restart of the machine after the death of a node.
struct Restart {
    std::string node;            ///< "gp-1"; empty if it is unknown.
    std::string cause;           ///< "gp-1 was killed by signal 9 (SIGKILL) (log: ...)".
    int gps = 0, renderers = 0;  ///< Nodes of the machine afterwards.
    double ms = 0;               ///< Time from the error to the restored scene.
    bool is_restored = true;     ///< False: the machine has lost its content.
};

class Recovery {
  public:
    explicit Recovery(Session& session) : session_(session) {}
    Recovery(const Recovery&) = delete;
    Recovery& operator=(const Recovery&) = delete;

    /// Takes a sentence for the user: before a restart, and when it is over.
    using Tell = std::function<void(const std::string& text, bool is_over)>;
    void on_restart(Tell tell) { tell_ = std::move(tell); }

    /// Runs `act`. If a node dies or hangs, starts the machine again as the topology's `restart`
    /// orders, restores the scene that was there before `act`, and runs `act` again. Calls may be
    /// nested: the innermost one recovers.
    ///
    /// Throws as `act`; the MachineError if the node may not or cannot be replaced; ContentLost.
    void run(const std::function<void()>& act) { run(act, false); }
    /// The same for `act` that waits for input: only deaths within a minute count together.
    void wait(const std::function<void()>& act) { run(act, true); }

    /// The restarts since the last call; the newest 100 if there are more.
    std::vector<Restart> take_restarts() { return std::exchange(restarts_, {}); }

  private:
    /// The next start of the machine.
    struct Attempt {
        std::string node, cause;
        NodeChange change;
        int pause_ms = 0;
        std::int64_t died_ns = 0;
        bool has_started = false;  ///< The machine runs. Its content may be missing.
    };
    void run(const std::function<void()>& act, bool is_wait);
    /// Throws `death` if it ends the machine.
    ///
    /// unfinished  The change of an attempt that did not start.
    Attempt plan(const MachineError& death, int number, const NodeChange& unfinished);
    void start_again(Attempt& attempt, const Scene& before);
    void note_restart(const Attempt& attempt, bool is_restored);
    void tell(const std::string& text, bool is_over) const;

    Session& session_;
    Tell tell_;
    std::vector<Restart> restarts_;
    std::int64_t restored_ns_ = 0;  ///< Time of the last restart.
    int row_ = 0;                   ///< Restarts, each within a minute after the one before.
};

/// "2 GPs, 1 Renderer".
std::string nodes_text(int gps, int renderers);

}  // namespace pxpl5::host
