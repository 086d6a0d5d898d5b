// The session's side of the viewer: does what viewers ask for, and shows what came of it.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "host/serve/director/audience.hpp"
#include "host/serve/director/inbox.hpp"
#include "host/serve/director/pace.hpp"
#include "host/session/session.hpp"

namespace pxpl5::host::serve {

inline constexpr double rest_ms = 150;  ///< Without input until the picture itself is drawn.
inline constexpr double machine_text_ms = 250;  ///< Between two `machine` messages.
inline constexpr int max_deaths = 3;            ///< Of the machine in `death_window_ms`: too many.
inline constexpr double death_window_ms = 60'000;

/// What a director is given.
struct DirectorParts {
    /// Launches the machine; the one before is over by then. Throws MachineError.
    std::function<std::shared_ptr<MachinePort>()> launch;
    std::string topology;             ///< Its name, for people.
    std::filesystem::path downloads;  ///< Where "download:NAME" of a command is written.
    /// Answers an `ask` message with a binary one. Empty: there are no such questions.
    std::function<std::string(Session&, std::uint32_t id, std::string_view message)> answer;
    /// What the nodes do, as the object of the message `machine`. Empty: nobody tells.
    std::function<std::string(Session&)> machine_text;
    std::function<std::int64_t()> clock_ns;  ///< Never goes back.
};

/// One thread uses it: the machine's. Nothing queues up behind a slow viewer or a slow machine: of
/// settings the newest is done, of frames the newest is shown.
class Director {
  public:
    Director(Audience& audience, DirectorParts parts);
    ~Director();
    Director(const Director&) = delete;
    Director& operator=(const Director&) = delete;

    /// Does a command of the program's own, before anybody looks. Throws as run_command().
    Reply open(const std::string& line);
    /// Shows something of what is loaded, if nothing is shown yet.
    void show_first_surfaces();

    /// Serves until the machine is interrupted, or has died too often: throws MachineError.
    void run();
    /// One round: takes what came and does the most urgent thing, if there is one.
    /// Returns whether there was one; if not, how long nothing is to do is due_ms().
    bool step();
    /// Milliseconds until step() has something to do even if nothing comes; -1: never.
    double due_ms() const;

    Session& session() { return *session_; }

  private:
    struct Viewer {
        Role role = Role::watcher;
        bool wants_machine = false;
    };

    void take_events();
    void take(const Joined& joined);
    void take(const Left& left);
    void take(const Said& said);
    void take_wish(const Said& said, Wish wish);
    bool may(const Said& said, const std::optional<std::string>& ask) const;
    void refuse(const Wish& wish, const RequestError& error);

    void do_wish(const Wish& wish);
    void do_command(const Wish& wish);
    void announce_frame(const Arguments& command);
    Reply run(const Arguments& arguments);
    void tell_opened();
    void answer_ask(const Wish& wish);
    void guard(const std::string& what, const std::function<void()>& act);
    void start_again(const MachineError& death, const Scene& scene);
    std::optional<MachineError> try_again(const History& history, const Scene& scene);
    void count_death(const MachineError& death);
    void start();
    void note(const char* level, const std::string& text);
    void tell_progress(const std::string& what, int done, int total);
    void end_progress();
    void tell_all(const std::string& text);
    std::string current_state() const;
    void tell_state();

    Size moving_size() const;
    bool draw_moving();
    bool draw_resting();
    int most_samples() const;
    bool is_refinable() const;
    void show(Picture picture, int samples, bool rests, bool last);
    bool has_picture() const;
    bool wants_machine() const;
    void tell_machine();
    double since_ms(std::int64_t then_ns) const;

    Audience& audience_;
    DirectorParts parts_;
    std::shared_ptr<MachinePort> machine_;
    std::unique_ptr<Session> session_;
    std::map<std::uint32_t, Viewer> viewers_;
    Inbox inbox_;
    Pace pace_;
    std::string opened_;  ///< What the server was told is open.
    std::string busy_;
    bool cancels_ = false;  ///< Somebody wants what is being done given up.
    bool tells_progress_ = false;
    std::int64_t progress_ns_ = 0;  ///< When it was told last.
    std::uint32_t revision_ = 1;
    std::uint32_t shown_revision_ = 0;  ///< Of the newest frame.
    int shown_samples_ = 0;             ///< Of the newest frame; 0 if it moves.
    bool state_is_old_ = true;
    std::string last_state_;     ///< As it was told last.
    std::int64_t input_ns_ = 0;  ///< When the newest change came.
    std::int64_t frame_ns_ = 0;  ///< When the newest frame was shown.
    std::int64_t machine_text_ns_ = 0;
    std::deque<std::int64_t> deaths_ns_;
};

}  // namespace pxpl5::host::serve
