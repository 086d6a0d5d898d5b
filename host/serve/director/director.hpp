// The session's side of the viewer: runs the viewers' commands and shows the results.
#pragma once

#include <cstdint>
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
#include "host/serve/director/state_text.hpp"
#include "host/serve/director/viewer_message.hpp"
#include "host/session/session.hpp"
#include "host/session/transfer/detail.hpp"

namespace pxpl5::host::serve {

inline constexpr double rest_ms = 150;  ///< Time without input before the resting picture is drawn.
inline constexpr double machine_text_ms = 250;  ///< Between two `machine` messages.

/// Time between the warning and the end of an unused session, in milliseconds.
double idle_warning_ms(double limit_ms);

/// Functions and settings of a director.
struct DirectorParts {
    std::shared_ptr<MachinePort> machine;
    std::string topology;             ///< The topology's name for the page.
    int class_port = 0;               ///< Port of the page of the class; 0: no class.
    std::filesystem::path downloads;  ///< Folder of "download:NAME" in a command.
    /// Throws RequestError for a viewer's command that may not be run. Empty: all may.
    std::function<void(const CommandDescriptor&, const Arguments&)> check_command;
    /// Answers an `ask` message with a binary message. Empty: the director answers no questions.
    std::function<std::string(Session&, std::uint32_t id, std::string_view message)> answer;
    /// Returns whether the `ask` message of a viewer will be answered later, while the session goes
    /// on. Empty: none is.
    std::function<bool(const Session&, std::uint32_t viewer, std::uint32_t id,
                       std::string_view message)>
        answer_later;
    /// Returns the object of the message `machine`, the nodes' work. Empty: no such messages.
    std::function<std::string(Session&)> machine_text;
    std::function<std::int64_t()> clock_ns;                  ///< Monotonic clock.
    std::int64_t moving_triangles = host::moving_triangles;  ///< See `detail auto`.
    /// Time without a viewer's command or question after which run() returns; 0: none.
    double idle_limit_ms = 0;
    /// File of the session that is saved before the end. Its folder is made if missing, for the
    /// owner alone.
    std::filesystem::path saved_session;
    /// Called when viewers are warned of the end, and when the session has been saved or could not
    /// be. May be empty.
    std::function<void(const EndNotice&)> tell_end_notice;
    /// Called when the machine is started again after a death, and when it runs again. May be
    /// empty.
    std::function<void(const std::string& text, bool is_over)> tell_restart;
    /// Called with the number of viewers when it changes. May be empty.
    std::function<void(std::size_t)> tell_viewers;
};

/// The machine's thread uses the director. No queue grows behind a slow viewer or a slow machine:
/// only the newest setting is run, and only the newest frame is shown.
class Director {
  public:
    Director(Audience& audience, DirectorParts parts);
    ~Director();
    Director(const Director&) = delete;
    Director& operator=(const Director&) = delete;

    /// Runs a command of the program, before viewers join. Throws as run_command() does.
    Reply open(const std::string& line);
    /// Plays a saved session, before viewers join. Its commands may not write files, because the
    /// file may come from a stranger. Throws as run_command() does.
    void open_session(const std::string& file);
    /// Adds the first surfaces of the loaded volume, if the scene has none, and fits the view.
    void show_first_surfaces();

    /// Serves until the limit for the time without use. Throws MachineError when the machine
    /// is interrupted or cannot be started again.
    void run();
    /// Returns whether the limit has passed.
    bool is_idle_too_long() const;
    /// Takes the messages that came and does the most urgent work. Returns false if there was no
    /// work. Then due_ms() is the time until the next work.
    bool step();
    /// Milliseconds until step() has work even without a message; -1: never.
    double due_ms() const;

    Session& session() { return *session_; }

  private:
    struct Viewer {
        Role role = Role::watcher;
        bool wants_machine = false;
    };

    void watch_viewers();
    void take_events();
    void tell_viewers() const;
    void take(const Joined& joined);
    void take(const Left& left);
    void take(const Said& said);
    void take(const Lost& lost);
    void take(const EndsSoon& soon);
    void take_wish(const Said& said, Wish wish);
    void take_eyes(std::uint32_t viewer, const ViewerMessage& message);
    void answer_eyes(std::uint32_t viewer, std::optional<std::uint32_t> id, bool is_superseded);
    void take_headset_off();
    bool do_at_once(const Wish& wish);
    void check_role(const Said& said, const ViewerMessage& message) const;
    void refuse(const Wish& wish, const RequestError& error);

    void do_wish(const Wish& wish);
    void do_command(const Wish& wish);
    void announce_frame(const Arguments& command);
    Reply run(const Arguments& arguments);
    void tell_opened();
    void answer_ask(const Wish& wish);
    void answer_slices();
    void guard(const std::string& what, const std::function<void()>& act);
    void tell_restart(const std::string& text, bool is_over);
    void tell_end(const MachineError& death);
    bool is_save_due() const;
    double idle_left_ms() const;
    bool warn_of_idle_end();
    void write_session(EndNotice& notice);
    void keep_session();
    void drop_kept_session();
    void tell_kept_session(const std::string& why);
    void save_session();
    bool put_back(const History& history, const Scene& scene);
    void start();
    void note(const char* level, const std::string& text);
    void tell_progress(const std::string& what, int done, int total);
    void end_progress();
    void tell_all(const std::string& text);
    std::string current_state() const;
    void tell_state();

    double moving_scale() const;
    Frames::Moving moving(double scale) const;
    int moving_detail(int views) const;
    bool draw_in_turn(bool rests);
    bool has_onlookers() const;
    bool is_pair_due() const;
    bool draw_pair();
    void send_drawn(Shown frame);
    double rest_due_ms() const;
    void draw_as_moving(const std::function<void()>& draw);
    bool draw_moving();
    bool draw_resting();
    int most_samples() const;
    bool is_refinable() const;
    std::size_t transparent_surfaces() const;
    ReadBack read_back() const;
    bool lacks_layers() const;
    bool draw_layers();
    bool draw_blended();
    void show(Picture picture, int samples, bool rests, bool last);
    void show_frame(Shown frame);
    bool has_picture() const;
    bool lacks_depths() const;
    bool wants_machine() const;
    void tell_machine();
    double since_ms(std::int64_t then_ns) const;

    /// The newest frame.
    struct ShownFrame {
        std::uint32_t revision = 0;
        int samples = 0;   ///< 0 for a moving picture.
        double scale = 1;  ///< Size of the newest moving picture, compared with that at rest.
        std::int64_t time_ns = 0;
        /// The resting picture of one sample, for its refinements: revision, views and depths,
        /// which may be empty.
        std::uint32_t resting_revision = 0;
        int resting_views = 0;
        SharedWords resting_depths = {};
        bool read_depths = false;  ///< The resting picture of one sample was drawn with depths.
        Camera camera = {};
        std::uint32_t layers_revision = 0;  ///< The newest frame with layers; 0: none.
        bool is_whole = true;  ///< No part of the newest moving picture was kept (SES-23).
    };

    /// The headset that one viewer wears.
    struct Headset {
        std::uint32_t viewer = 0;         ///< 0: no viewer wears one.
        std::optional<HeadsetEyes> eyes;  ///< The newest.
        std::optional<std::uint32_t> id;  ///< The message of these eyes, if not answered.
        std::int64_t eyes_ns = 0;         ///< Time of this message.
        std::uint32_t pose = 0;           ///< Pose of the newest pair; 0: none yet.
        std::uint32_t revision = 0;       ///< Revision of the newest pair.
        std::int64_t drawn_ns = 0;        ///< Time of the newest pair.
        bool had_turn = false;            ///< The newest picture is a pair.
        Pace pace;
    };

    Audience& audience_;
    DirectorParts parts_;
    std::unique_ptr<Session> session_;
    std::map<std::uint32_t, Viewer> viewers_;
    Inbox inbox_;
    Pace pace_;
    std::string opened_;  ///< The open file or folder that the server knows.
    std::string busy_;
    std::string busy_before_;     ///< Before the machine was started again.
    bool is_restarting_ = false;  ///< The machine is started again.
    struct Work {
        bool is_command = false;  ///< A command is under way, not only a picture.
        bool waits = false;       ///< The session waits for nodes while events are taken.
        bool cancels = false;     ///< A viewer has canceled the command under way.
    };
    Work work_;
    struct Progress {
        bool is_told = false;
        std::int64_t time_ns = 0;  ///< Time of the last message.
    };
    Progress progress_;
    std::uint32_t revision_ = 1;
    ShownFrame shown_;
    Headset headset_;
    bool state_is_old_ = true;
    std::string last_state_;     ///< The last state sent.
    std::int64_t input_ns_ = 0;  ///< Time of the newest change.
    std::int64_t machine_text_ns_ = 0;
    struct End {
        std::string lost;                 ///< Why the server has ended; empty while it runs.
        std::optional<EndNotice> notice;  ///< The program ends soon, and why.
        EndNotice kept;  ///< The session as it was before the restart that may fail.
        std::uint32_t saved_revision = 0;
        std::int64_t used_ns = 0;      ///< Time when a driver joined, commanded or asked.
        bool is_because_idle = false;  ///< The notice announces the idle limit.
    };
    End end_;
};

}  // namespace pxpl5::host::serve
