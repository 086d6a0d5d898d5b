// The sessions of a class: which browser has which one.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "host/machine/sessions/session_note.hpp"
#include "host/serve/server/greeter.hpp"

namespace pxpl5::host::serve {

/// A session that is to be started.
struct WantedSession {
    int number = 0;  ///< Counts all sessions from 1; never used again.
    int place = 0;   ///< From 1 to the number of sessions at the same time; used again.
};

/// Two threads use the classroom: that of the greeter, and that which starts the sessions.
class Classroom final : public Receptionist {
  public:
    /// places    Sessions at the same time.
    /// facts_of  Returns what a session's process says of itself; no address until it is ready.
    /// wake      Called in the greeter's thread when a session is wanted, and when is_lost().
    Classroom(int places, std::function<SessionFacts(pid_t)> facts_of, std::function<void()> wake);

    Greeting greet_known(const std::function<bool(const std::string&)>& has_shown) override;
    Greeting greet_new() override;
    bool has_port(int port) override;
    void lost() override;

    /// Sessions that are wanted since the last call.
    std::vector<WantedSession> take_wanted();
    /// The session runs as this process.
    void started(int number, pid_t pid);
    /// The session has ended, or could not start.
    ///
    /// why  A sentence for the browser.
    void ended(int number, const std::string& why);
    /// Returns whether the greeter cannot go on.
    bool is_lost() const { return is_lost_; }
    /// Sessions that are wanted, start or run.
    int taken() const;

  private:
    struct Seat {
        WantedSession session;
        std::string secret;
        pid_t pid = 0;  ///< 0 until the process runs.
        bool is_wanted = true;
        int port = 0;  ///< 0 until the session is ready.
        std::string token = {};
    };
    /// A browser without a session. It gets one when it shows its cookie: a browser that keeps no
    /// cookies would take one session after the other.
    struct Guest {
        std::string secret;
        std::string why;  ///< Why its last session has ended; empty once the browser was told.
    };

    void welcome(Guest guest);
    Greeting begin(const std::string& secret);
    Greeting look(Seat& seat) const;

    int places_;
    std::function<SessionFacts(pid_t)> facts_of_;
    std::function<void()> wake_;
    mutable std::mutex mutex_;
    std::vector<Seat> seats_;
    std::vector<Guest> guests_;  ///< The oldest first.
    int last_number_ = 0;
    std::atomic<bool> is_lost_ = false;
};

}  // namespace pxpl5::host::serve
