// Launcher: deaths, signals, and the end.
#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstddef>
#include <cstring>
#include <span>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/kernel/standard_streams.hpp"
#include "host/machine/computers/end_deadline.hpp"
#include "host/machine/launcher.hpp"

namespace pxpl5::host {

namespace {

constexpr int failed_drain_ms = 500;  // From Shutdown to SIGTERM after a failure.
constexpr int terminate_ms = 1000;    // From SIGTERM to SIGKILL.
constexpr int max_discarded = 4096;
constexpr int killed_ms = 10'000;  // From SIGKILL until the host leaves a process to the kernel.
constexpr std::string_view ipc_scheme = "ipc://";

/// The next step of the end, after a step took too long or the user pressed Ctrl-C again.
struct Step {
    int signal;
    int patience_ms;
};
constexpr std::array steps = {Step{SIGTERM, terminate_ms}, Step{SIGKILL, killed_ms}};

/// Whether the host has sent this signal in one of the first `taken` steps.
bool was_sent(int signal, std::size_t taken) {
    return std::ranges::any_of(std::span(steps).first(taken),
                               [signal](const Step& step) { return step.signal == signal; });
}

}  // namespace

void Launcher::allow_cancel(bool allowed) {
    interrupt_.cancels = false;
    if (allowed) {
        check_health();  // An earlier signal cancels nothing, unless cancel_on_interrupt() says so.
    }
    interrupt_.cancels = allowed;
}

void Launcher::watch(int fd, std::function<bool()> give_up) {
    watcher_ = {fd,
                std::move(give_up),
                false,
                false,
                std::move(watcher_.tell_suspect),
                std::move(watcher_.tell_computer)};
}

void Launcher::ask_watcher() {
    pollfd watched{watcher_.fd, POLLIN, 0};
    if (watcher_.fd >= 0 && poll(&watched, 1, 0) > 0 && watcher_.give_up()) {
        watcher_.has_given_up = true;
    }
    if ((watcher_.has_given_up || interrupt_.is_pending) &&
        (interrupt_.cancels || watcher_.may_cancel)) {
        watcher_.has_given_up = false;
        interrupt_.is_pending = false;
        cancel();
    }
}

void Launcher::cancel_on_interrupt(bool allowed) {
    if (interrupt_.cancels_command && !allowed && !interrupt_.is_pending) {
        wait_for_event(0);  // It may have come after the last look.
        processes_.own().forget_interrupt(SIGINT);
    }
    interrupt_.cancels_command = allowed;
    interrupt_.is_pending = false;
}

void Launcher::cancel() {
    interrupt_.cancels = false;
    if (io_.used && io_.death_code == ExitCode::failed) {
        // It removes what it has written so far, unless something has stopped it.
        end_process(io_.used->name(), SIGTERM, terminate_ms);
    }
    kill_io();
    throw Canceled();
}

void Launcher::blame(bus::NodeId id, int code, const std::string& text) {
    if (io_.used && io_.used->id == id) {
        const std::string name = io_.used->name();
        kill_io();
        throw RequestError(io_.death_code,
                           fmt::format("{} broke the protocol and was killed: {}", name, text));
    }
    if (io_.prepared && io_.prepared->id == id) {
        drop_prepared_io();
    } else if (io_.dismissed.count(id) == 0) {
        fail(code, text, name_of(id));
    }
}

void Launcher::take_refusal(const bus::Refusal& refusal) {
    const bool is_node = std::any_of(roster_.begin(), roster_.end(), [&](const RosterEntry& node) {
        return node.id == refusal.source;
    });
    if (refusal.has_joined && !is_node) {
        io_.offense = refusal;
    } else if (!over_) {
        print_notice(
            "warning",
            fmt::format("the ring dropped {}; more of this kind are only counted", refusal.text));
    }
}

void Launcher::report_refusals() const {
    const std::uint64_t count = link_.traffic().refused_messages +
                                (processes_.has_others() ? processes_.others().refused() : 0);
    if (count > 0) {
        print_notice("warning", fmt::format("the host dropped {} message{} without a lawful sender",
                                            count, count == 1 ? "" : "s"));
    }
}

std::string Launcher::describe(const Death& death) const {
    const std::filesystem::path log = processes_.log_of(death.name);
    const std::string said = last_words(log);
    return fmt::format("{}{}{} (log: {})", death.text(), said.empty() ? "" : ": ", said,
                       log.string());
}

void Launcher::kill(bus::NodeId id) {
    if (over_) {
        throw *over_;
    }
    end_process(name_of(id), SIGKILL, killed_ms);
}

void Launcher::check_health() {
    if (over_) {
        throw *over_;
    }
    wait_for_event(0);
    if (processes_.has_others()) {
        print_news_of_computers();
    }
    std::optional<Death> io_death;
    for (const Death& death : processes_.take_deaths()) {
        if (io_.used && io_.used->name() == death.name) {
            io_death = death;
        } else if (io_.prepared && io_.prepared->name() == death.name) {
            heartbeat_.forget(death.name);
            io_.prepared.reset();  // The next start_io() tries again and reports the failure.
            io_.early_hello.reset();
        } else if (!was_dismissed(death)) {
            fail(death.code(), describe(death), death.name);
        }
    }
    if (const int signal = processes_.own().take_interrupt();
        signal == SIGINT && interrupt_.cancels) {
        cancel();
    } else if (signal == SIGINT && interrupt_.cancels_command && !interrupt_.is_pending) {
        interrupt_.is_pending = true;
    } else if (signal != 0) {
        give_in(interruption(signal));
    }
    ask_watcher();
    if (!io_death) {
        check_heartbeat();
    }
    if (io_death) {
        const IoFailure error = io_error(*io_death);
        io_.used->endpoint.clear();
        dismiss_io();
        throw error;
    }
    if (record_failure_) {
        const std::string text = *std::exchange(record_failure_, std::nullopt);
        throw RequestError(ExitCode::failed, "recording stops: " + text);
    }
}

void Launcher::check_heartbeat() {
    for (const Heartbeat::Finding& found : heartbeat_.look(now_ms())) {
        if (!found.is_dead) {
            print_notice("warning", found.text);
            if (watcher_.tell_suspect) {
                watcher_.tell_suspect(found.text);
            }
        } else if (io_.prepared && io_.prepared->name() == found.name) {
            drop_prepared_io();
        } else if (io_.used && io_.used->name() == found.name) {
            kill_io();
            throw IoFailure(
                ExitCode::failed,
                fmt::format("{}: {}. The host has ended this process: repeat the command{}", work_,
                            found.text,
                            found.is_stopped ? ". With --set heartbeat.misses=0, the host waits "
                                               "for a stopped process"
                                             : ""));
        } else {
            // The kernel then writes a core file if the limits allow one. A stopped process must
            // continue to receive the signal.
            processes_.kill(found.name, SIGABRT);
            processes_.kill(found.name, SIGCONT);
            fail(timeout_code, found.text, found.name);
        }
    }
    if (heartbeat_.is_suspicious()) {
        check_answer();
    }
}

void Launcher::check_answer() {
    const double waited_s = static_cast<double>(heartbeat_.quiet_ms()) / 1000;
    const bool is_ipc = topology_.ring.transport == Transport::ipc;
    for (const RosterEntry& node : roster_) {
        const std::string path = node.endpoint.substr(ipc_scheme.size());
        if (is_ipc && !std::filesystem::exists(path)) {
            fail(static_cast<int>(ExitCode::failed),
                 fmt::format("{}: no answer for {:.1f} s, because the socket {} was removed. Keep "
                             "programs that clean up temporary files away from it, or set "
                             "XDG_RUNTIME_DIR to another folder",
                             work_, waited_s, path));
        }
    }
    if (heartbeat_.is_lost()) {
        fail(timeout_code, fmt::format("{}: no answer, although no node has had work for {:.1f} s",
                                       work_, waited_s));
    }
}

void Launcher::end_process(const std::string& name, int signal, int most_ms) {
    if (!processes_.has_others() || !processes_.others().has(name)) {
        processes_.own().end(name, signal, most_ms);
        return;
    }
    processes_.kill(name, signal);
    const std::int64_t end_ms = now_ms() + most_ms;
    while (processes_.others().has(name) && now_ms() < end_ms) {
        wait_for_event(static_cast<int>(end_ms - now_ms()));
    }
}

void Launcher::fail(int code, const std::string& text, const std::string& node) {
    MachineError cause(code, text + traces_of_failure());
    cause.node = node;
    give_in(cause);
}

void Launcher::rest(int ms) {
    const std::int64_t end_ms = now_ms() + ms;
    std::int64_t left_ms = ms;
    do {
        wait_for_event(static_cast<int>(left_ms));
        if (const int signal = processes_.own().take_interrupt(); signal != 0) {
            throw interruption(signal);
        }
        if (over_) {
            discard_messages(false);
            processes_.take_deaths();
        }
        left_ms = end_ms - now_ms();
    } while (left_ms > 0);
}

void Launcher::give_in(const MachineError& cause) {
    over_ = cause;
    // The session may go on with the other computers. Before Go, no node has work to finish.
    bring_down(launched_ ? failed_drain_ms : 0,
               cause.is_interruption ? Ending::all : Ending::nodes);
    throw *over_;
}

void Launcher::shutdown(Ending ending) {
    if (over_) {
        throw *over_;
    }
    dismiss_io();
    check_health();  // An earlier event is the cause, not a second Ctrl-C.
    report_refusals();
    over_.emplace(1, "the machine has been shut down");
    if (const std::optional<MachineError> cause = bring_down(options_.drain_ms, ending)) {
        throw *cause;
    }
}

std::optional<MachineError> Launcher::bring_down(int grace_ms, Ending ending) {
    drop_prepared_io();
    for (const RosterEntry& node : roster_) {
        if (node.id != bus::host_id && !node.endpoint.empty()) {
            link_.send(node.id, shutdown_message());
        }
    }
    const std::optional<MachineError> cause = end_processes(grace_ms, ending);
    const std::optional<MachineError> unwritten = close_trace();
    return cause ? cause : unwritten;
}

std::optional<MachineError> Launcher::end_processes(int grace_ms, Ending ending) {
    std::optional<MachineError> cause;
    std::size_t step = 0;
    EndDeadline deadline(now_ms(), grace_ms);
    const auto still_running = [&] {
        return ending == Ending::all ? processes_.running() : processes_.running_nodes();
    };
    for (std::vector<std::string> left; !(left = still_running()).empty();) {
        if (processes_.running_nodes().empty()) {
            processes_.finish();
        }
        const bool patient = step == steps.size();
        if (!patient && processes_.has_others() && processes_.others().takes_parts()) {
            deadline.take_part(now_ms());
        }
        if (patient && deadline.is_over(now_ms())) {
            const std::string text =
                fmt::format("{} cannot be ended: the kernel keeps it {} s after SIGKILL",
                            fmt::join(left, ", "), killed_ms / 1000);
            print_notice("warning", text);
            cause = cause ? cause : MachineError(ExitCode::failed, text);
            break;
        }
        wait_for_event(static_cast<int>(deadline.left_ms(now_ms())));
        discard_messages(true);  // The last messages belong to the trace.
        for (Death& death : processes_.take_deaths()) {
            const bool expected = death.signal == 0 && death.exit_code == 0;
            if (cause || expected || was_dismissed(death)) {
                continue;
            }
            if (was_sent(death.signal, step)) {
                death.why = fmt::format(
                    "{0} did not end after Shutdown. The host ended {0} with "
                    "SIG{1}",
                    death.name, sigabbrev_np(death.signal));
                cause.emplace(timeout_code, describe(death));
            } else {
                cause.emplace(death.code(), describe(death));
            }
        }
        left = still_running();
        const int signal = processes_.own().take_interrupt();
        over_->is_final |= signal != 0;  // The user wants the program to end.
        if (!patient && !left.empty() && (signal != 0 || deadline.is_over(now_ms()))) {
            if (!cause && signal != 0) {
                cause = interruption(signal);  // The signal causes the deaths that follow.
            }
            if (launched_ || step > 0) {
                fmt::print(stderr, "still running: {}; sending SIG{}\n", fmt::join(left, ", "),
                           sigabbrev_np(steps[step].signal));
            }
            processes_.kill_all(steps[step].signal, ending == Ending::nodes);
            deadline.begin_step(now_ms(), steps[step].patience_ms);
            ++step;
        }
    }
    if (ending == Ending::all) {
        processes_.finish();
    }
    wait_for_event(0);
    over_->is_final |= processes_.own().take_interrupt() != 0;
    return cause;
}

void Launcher::discard_messages(bool are_recorded) {
    bool more = true;
    for (int count = 0; more && count < max_discarded; ++count) {
        try {
            const std::optional<bus::Message> message = link_.receive();
            more = message.has_value();
            if (message && are_recorded) {
                note(*message);
            }
        } catch (const std::runtime_error&) {
            // The machine is ending already.
        }
    }
}

}  // namespace pxpl5::host
