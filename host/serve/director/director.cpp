#include "host/serve/director/director.hpp"

#include <fmt/core.h>
#include <sys/epoll.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/reply.hpp"
#include "host/base/version.hpp"

namespace pxpl5::host::serve {

namespace {

constexpr double ms_per_ns = 1e-6;

/// A descriptor that is readable when `fd` is readable, or after a time.
class Alarm {
  public:
    explicit Alarm(int fd)
        : timer_(timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK)),
          set_(epoll_create1(EPOLL_CLOEXEC)) {
        for (const int each : {fd, timer_}) {
            epoll_event event{};
            event.events = EPOLLIN;
            if (epoll_ctl(set_, EPOLL_CTL_ADD, each, &event) != 0) {
                throw std::system_error(errno, std::generic_category(), "cannot wait for viewers");
            }
        }
    }
    ~Alarm() {
        close(set_);
        close(timer_);
    }
    Alarm(const Alarm&) = delete;
    Alarm& operator=(const Alarm&) = delete;

    int fd() const { return set_; }
    /// ms  -1: never.
    void set(double ms) const {
        itimerspec after{};
        if (ms >= 0) {
            const auto ns = static_cast<std::int64_t>(std::max(1.0, ms / ms_per_ns));
            after.it_value = {ns / 1'000'000'000, ns % 1'000'000'000};
        }
        timerfd_settime(timer_, 0, &after, nullptr);  // Also makes the timer unreadable.
    }

  private:
    int timer_, set_;
};

}  // namespace

Director::Director(Audience& audience, DirectorParts parts)
    : audience_(audience), parts_(std::move(parts)) {
    end_.used_ns = parts_.clock_ns();
    start();
}
Director::~Director() {
    parts_.machine->watch(-1, {});  // The machine may outlive the director.
    parts_.machine->tell_suspects({});
    parts_.machine->tell_computers({});
}

void Director::start() {
    watch_viewers();
    parts_.machine->tell_suspects([this](const std::string& text) { note("info", text); });
    parts_.machine->tell_computers([this](const std::string& text) { note("info", text); });
    session_ = std::make_unique<Session>(*parts_.machine);
    session_->recovery.on_restart(
        [this](const std::string& text, bool is_over) { tell_restart(text, is_over); });
    session_->check_command = parts_.check_command;
    session_->load_settings.progress = [this](const LoadProgress& progress) {
        if (is_restarting_) {
            return;  // Its name would offer to cancel it.
        }
        const bool reads = progress.phase == LoadProgress::Phase::reading;
        tell_progress(reads ? "reading" : "handing to the GPs", progress.done, progress.total);
    };
    session_->tell_pictures = [this](int done, int total) {
        if (!is_restarting_) {
            tell_progress(fmt::format("picture {} of {},", done, total), done, total);
        }
    };
}

/// Takes the viewers' messages also while the session waits for nodes: a node may be slow or stuck.
void Director::watch_viewers() {
    parts_.machine->watch(audience_.event_fd(), [this] {
        work_.waits = true;
        take_events();
        work_.waits = false;
        return work_.is_command && std::exchange(work_.cancels, false);
    });
}

double Director::since_ms(std::int64_t then_ns) const {
    return static_cast<double>(parts_.clock_ns() - then_ns) * ms_per_ns;
}

void Director::run() {
    const Alarm alarm(audience_.event_fd());
    for (;;) {
        while (end_.lost.empty() && !is_idle_too_long() && step()) {
        }
        if (!end_.lost.empty()) {
            throw RequestError(ExitCode::unavailable, end_.lost);
        }
        if (is_idle_too_long()) {
            return;
        }
        alarm.set(due_ms());
        parts_.machine->watch(-1, {});  // The events must stay unread, because they end the wait.
        guard("waiting", [&] { parts_.machine->wait_readable(alarm.fd()); });
        watch_viewers();
    }
}

bool Director::step() {
    take_events();
    if (inbox_.has_command()) {
        // Pictures keep their rate even while input floods in.
        const bool picture_is_due =
            has_onlookers() && shown_.revision != revision_ &&
            (since_ms(shown_.time_ns) >= goal_ms || session_->frames.has_frame_ahead());
        const bool pair_is_due = is_pair_due() && since_ms(headset_.drawn_ns) >= goal_ms;
        if (!((picture_is_due || pair_is_due) && draw_in_turn(false))) {
            do_wish(inbox_.take());
        }
        return true;
    }
    if (state_is_old_) {
        tell_state();
    }
    if (wants_machine() && since_ms(machine_text_ns_) >= machine_text_ms) {
        tell_machine();
        return true;
    }
    if (warn_of_idle_end()) {
        return true;
    }
    if (is_save_due()) {
        save_session();
        return true;
    }
    const bool is_asked = !inbox_.empty();
    if (is_asked) {
        do_wish(inbox_.take());
    }
    // Draws after each answer, so that a viewer's constant questions do not delay pictures.
    return draw_in_turn(true) || is_asked;
}

double Director::due_ms() const {
    double due = -1;
    const auto sooner = [&due](double ms) {
        due = due < 0 ? std::max(0.0, ms) : std::min(due, std::max(0.0, ms));
    };
    if (has_picture() && is_refinable()) {
        sooner(rest_due_ms());
    }
    if (end_.notice && end_.saved_revision != revision_) {
        sooner(rest_ms - since_ms(input_ns_));
    }
    if (wants_machine()) {
        sooner(machine_text_ms - since_ms(machine_text_ns_));
    }
    if (parts_.idle_limit_ms > 0) {
        sooner(idle_left_ms() - (end_.notice ? 0 : idle_warning_ms(parts_.idle_limit_ms)));
    }
    return due;
}

void Director::take_events() {
    for (const Event& event : audience_.take()) {
        std::visit([this](const auto& each) { take(each); }, event);
    }
}

void Director::take(const Joined& joined) {
    viewers_[joined.viewer] = {joined.role, false};
    end_.used_ns = joined.role == Role::driver ? parts_.clock_ns() : end_.used_ns;
    tell_viewers();
    audience_.send(
        joined.viewer,
        json_text({{"hello", Fields{{"version", std::string(version)},
                                    {"role", std::string(joined.role == Role::driver ? "driver"
                                                                                     : "watcher")},
                                    {"viewer", std::int64_t{joined.viewer}},
                                    {"topology", parts_.topology},
                                    {"class_port", std::int64_t{parts_.class_port}},
                                    {"commands", table_fields()}}}}));
    // During work the scene is incomplete, so the last state is sent.
    const bool is_complete = busy_.empty() && !work_.waits;
    audience_.send(joined.viewer, is_complete ? current_state() : last_state_);
}

void Director::take(const Lost& lost) {
    end_.lost = lost.reason;
    work_.cancels = true;  // The command under way is for viewers who are gone.
}

void Director::take(const Left& left) {
    viewers_.erase(left.viewer);
    inbox_.forget_asks(left.viewer);
    if (left.viewer == headset_.viewer) {
        take_headset_off();
    }
    tell_viewers();
}

void Director::tell_viewers() const {
    if (parts_.tell_viewers) {
        parts_.tell_viewers(viewers_.size());
    }
}

/// Throws RequestError unless the viewer's role allows the message.
void Director::check_role(const Said& said, const ViewerMessage& message) const {
    if (said.role == Role::driver || message.ask == "slice") {
        return;
    }
    refuse_command(message.is_of_headset
                       ? "you only watch: a headset needs the address for drivers"
                       : "you only watch: the address of this page may not change anything");
}

void Director::take(const Said& said) {
    Wish wish;
    wish.viewer = said.viewer;
    try {
        const ViewerMessage message = read_viewer_message(said.text);
        wish.id = message.id;
        if (message.panel) {
            viewers_[said.viewer].wants_machine = *message.panel;
            return;
        }
        if (message.is_ping) {
            audience_.send(said.viewer, json_text({{"re", std::int64_t{*wish.id}}, {"ok", true}}));
            return;
        }
        check_role(said, message);
        if (message.cancels) {
            work_.cancels = true;  // For the command under way; do_command() resets the flag.
            return;
        }
        end_.used_ns = said.role == Role::driver ? parts_.clock_ns() : end_.used_ns;
        if (message.is_of_headset) {
            take_eyes(said.viewer, message);
            return;
        }
        wish.is_ask = message.ask.has_value();
        wish.text = wish.is_ask ? said.text : *message.line;
        wish.kind = message.ask.value_or("") + " " + message.axis.value_or("") +
                    (message.is_ahead ? " ahead" : "");
        take_wish(said, std::move(wish));
    } catch (const MessageError& error) {
        wish.id = error.id;
        refuse(wish, error);
    } catch (const RequestError& error) {
        refuse(wish, error);
    }
}

void Director::take_wish(const Said& said, Wish wish) {
    if (!wish.is_ask) {
        wish.arguments = parse_line(wish.text);
        if (wish.arguments.name.empty()) {
            refuse_command("do: the line is empty");
        }
        if (is_quit(wish.arguments)) {
            refuse_command("the program is ended where it was started, with Ctrl-C");
        }
    }
    if (!wish.is_ask && do_at_once(wish)) {
        return;
    }
    const std::optional<std::uint32_t> id = wish.id;
    const Inbox::Outcome outcome = inbox_.add(std::move(wish));
    if (outcome.superseded && outcome.superseded->id) {
        audience_.send(outcome.superseded->viewer,
                       json_text({{"re", std::int64_t{*outcome.superseded->id}},
                                  {"ok", false},
                                  {"superseded", true}}));
    }
    if (outcome.added == Inbox::Added::full) {
        Wish lost;
        lost.viewer = said.viewer;
        lost.id = id;
        refuse(lost, RequestError(ExitCode::failed,
                                  fmt::format("{} commands, or {} questions of this viewer, wait "
                                              "already, no more may: this one is not done",
                                              max_waiting, max_asks_of_a_viewer)));
    }
}

void Director::refuse(const Wish& wish, const RequestError& error) {
    if (wish.id) {
        audience_.send(wish.viewer,
                       json_text({{"re", std::int64_t{*wish.id}},
                                  {"ok", false},
                                  {"error", std::string(error.what())},
                                  {"exit_code", static_cast<std::int64_t>(error.code)}}));
    } else {
        audience_.send(wish.viewer,
                       json_text({{"note", Fields{{"level", std::string("error")},
                                                  {"text", std::string(error.what())}}}}));
    }
}

void Director::note(const char* level, const std::string& text) {
    tell_all(json_text({{"note", Fields{{"level", std::string(level)}, {"text", text}}}}));
}

void Director::tell_progress(const std::string& what, int done, int total) {
    // Sends the first text at once, the others at a readable rate.
    constexpr double pause_ms = 50;
    if (busy_.empty() ||
        (progress_.is_told && done != total && since_ms(progress_.time_ns) < pause_ms)) {
        return;
    }
    progress_ = {true, parts_.clock_ns()};
    tell_all(json_text(
        {{"progress",
          Fields{{"what", what}, {"done", std::int64_t{done}}, {"total", std::int64_t{total}}}}}));
}

void Director::end_progress() {
    if (std::exchange(progress_.is_told, false)) {
        tell_all(json_text({{"progress", nullptr}}));
    }
}

/// Sends a text to all viewers that have received the greeting.
void Director::tell_all(const std::string& text) {
    for (const auto& viewer : viewers_) {
        audience_.send(viewer.first, text);
    }
}

std::string Director::current_state() const {
    return state_text(*session_, {revision_, busy_, parts_.topology, parts_.machine->is_recording(),
                                  end_.notice});
}

void Director::tell_state() {
    state_is_old_ = false;
    last_state_ = current_state();
    tell_all(last_state_);
}

}  // namespace pxpl5::host::serve
