// The sessions of a class: which browser has which one.
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "host/serve/server/class_page.hpp"

namespace pxpl5::host::serve {

/// A session that is to be started.
struct WantedSession {
    int number = 0;  ///< Counts all sessions from 1; never used again.
    int place = 0;   ///< From 1 to the number of sessions at the same time; used again.
};

/// Two threads use the classroom: that of the page, and that which starts the sessions.
class Classroom final : public ClassAnswers {
  public:
    /// places  Sessions at the same time.
    /// wake    Called in the page's thread when a session is wanted, and when the page has failed.
    Classroom(int places, std::function<void()> wake);

    PageAnswer answer_known(const std::function<bool(const std::string&)>& has_shown) override;
    PageAnswer answer_new() override;
    bool has_port(int port) override;
    void fail() override;

    /// Asks for a session ahead, which the first browser gets.
    void want_one();
    /// Sessions that are wanted since the last call.
    std::vector<WantedSession> take_wanted();
    /// The session can be opened at this address: "http://127.0.0.1:4711/?token=T".
    void ready(int number, const std::string& url);
    /// The session has ended, or could not start.
    ///
    /// why  A sentence for the browser.
    void ended(int number, const std::string& why);
    /// Sessions that are wanted, start or run.
    int taken() const;
    /// Returns whether the page cannot go on.
    bool has_failed() const { return has_failed_; }

  private:
    struct Entry {
        WantedSession session;
        std::string secret;  ///< The cookie of its browser; empty until it has one.
        bool is_wanted = true;
        int port = 0;  ///< 0 until the session is ready.
        std::string token = {};
    };
    /// A browser without a session. It gets one when it shows its cookie: a browser that keeps no
    /// cookies would take one session after the other.
    struct Waiting {
        std::string secret;
        std::string why;  ///< Why its last session has ended; empty once the browser has read it.
    };

    void add_waiting(Waiting waiting);
    PageAnswer begin(const std::string& secret);
    void add_entry(const std::string& secret);
    int next_place();

    int places_;
    std::function<void()> wake_;
    mutable std::mutex mutex_;
    std::vector<Entry> entries_;
    std::vector<Waiting> waiting_;  ///< The oldest first.
    int last_number_ = 0, last_place_ = 0;
    std::atomic<bool> has_failed_ = false;
};

}  // namespace pxpl5::host::serve
