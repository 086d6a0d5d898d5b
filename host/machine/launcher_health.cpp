// Launcher: the io process, deaths, signals, and the end.
#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstring>
#include <fstream>
#include <utility>

#include "host/base/error.hpp"
#include "host/machine/launcher.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

constexpr int failed_drain_ms = 500;  // From Shutdown to SIGTERM after a failure.
constexpr int terminate_ms = 1000;    // From SIGTERM to SIGKILL.

/// The last line of a process's log, its reason for ending. Empty if the process wrote no line.
std::string last_words(const std::filesystem::path& log) {
    std::ifstream file(log);
    std::string line, last;
    std::getline(file, line);  // The first line names the program.
    while (std::getline(file, line)) {
        last = line.empty() ? last : line;
    }
    return last;
}

bus::Payload shutdown_message() {
    schema::ShutdownT message;
    message.reason = "the host is done";
    return bus::pack(message);
}

/// The next step of the end, after a step took too long or the user pressed Ctrl-C again.
struct Step {
    int signal;
    int patience_ms;  ///< -1: the last step.
};
constexpr std::array steps = {Step{SIGTERM, terminate_ms}, Step{SIGKILL, -1}};

MachineError interruption(int signal) {
    MachineError error(128 + signal, fmt::format("interrupted by SIG{}", sigabbrev_np(signal)));
    error.is_interruption = true;
    return error;
}

}  // namespace

RosterEntry Launcher::spawn_io() {
    bury_dismissed();
    RosterEntry node;
    node.id = static_cast<bus::NodeId>(roster_.size() + static_cast<std::size_t>(io_.count));
    node.role = schema::Role::io;
    node.index = io_.count++;
    try {
        spawn(node, {},
              {"--memory-mib", std::to_string(options_.io_memory_mib), "--cpu-s",
               std::to_string(options_.io_cpu_s)});
    } catch (const MachineError& error) {
        throw RequestError(ExitCode::unavailable, error.what());
    }
    return node;
}

void Launcher::prepare_io() {
    if (!io_.prepared) {
        io_.prepared = spawn_io();
    }
}

bus::NodeId Launcher::start_io(ExitCode on_death) {
    dismiss_io();
    check_health();  // A prepared process that has died was not killed by bad data.
    io_.used = io_.prepared ? *std::exchange(io_.prepared, std::nullopt) : spawn_io();
    io_.death_code = on_death;
    io_.used = bring_up({*io_.used}).front();
    return io_.used->id;
}

/// Ends a prepared process that has no request.
void Launcher::drop_prepared_io() {
    if (io_.prepared) {
        supervisor_.kill(io_.prepared->name(), SIGKILL);
        io_.dismissed.emplace(io_.prepared->id, io_.prepared->name());
        io_.prepared.reset();
        io_.early_hello.reset();
    }
}

void Launcher::release_io() {
    dismiss_io();
}

void Launcher::dismiss_io() {
    if (!io_.used) {
        return;
    }
    if (!io_.used->endpoint.empty()) {
        link_.send(io_.used->id, shutdown_message());
    }
    io_.dismissed.emplace(io_.used->id, io_.used->name());
    std::erase_if(backlog_, [this](const bus::Message& message) {
        const bool is_its_own = message.source() == io_.used->id;
        backlog_bytes_ -= is_its_own ? message.bytes().size() : 0;
        return is_its_own;
    });
    io_.used.reset();
}

void Launcher::allow_cancel(bool allowed) {
    can_be_cancelled_ = false;
    if (allowed) {
        check_health();  // An earlier signal does not cancel the operation that begins now.
    }
    can_be_cancelled_ = allowed;
}

void Launcher::watch(int fd, std::function<bool()> give_up) {
    watched_fd_ = fd;
    give_up_ = std::move(give_up);
}

void Launcher::ask_watcher() {
    pollfd watched{watched_fd_, POLLIN, 0};
    if (watched_fd_ >= 0 && poll(&watched, 1, 0) > 0 && give_up_() && can_be_cancelled_) {
        cancel();
    }
}

void Launcher::cancel() {
    can_be_cancelled_ = false;
    if (io_.used) {
        supervisor_.kill(io_.used->name(), SIGKILL);
        io_.used->endpoint.clear();
        dismiss_io();
    }
    throw Cancelled();
}

void Launcher::bury_dismissed() {
    const std::vector<std::string> running = supervisor_.running();
    for (auto past = io_.dismissed.begin(); past != io_.dismissed.end();) {
        if (std::find(running.begin(), running.end(), past->second) != running.end()) {
            supervisor_.kill(past->second, SIGKILL);
            ++past;
        } else {
            link_.remove_peer(past->first);
            past = io_.dismissed.erase(past);
        }
    }
}

bool Launcher::was_dismissed(const Death& death) const {
    return std::any_of(io_.dismissed.begin(), io_.dismissed.end(),
                       [&death](const auto& past) { return past.second == death.name; });
}

std::string Launcher::describe(const Death& death) const {
    const std::filesystem::path log = folder_ / (death.name + ".log");
    const std::string said = last_words(log);
    return fmt::format("{}{}{} (log: {})", death.text(), said.empty() ? "" : ": ", said,
                       log.string());
}

void Launcher::kill(bus::NodeId id) {
    if (over_) {
        throw *over_;
    }
    supervisor_.end(name_of(id));
}

void Launcher::check_health() {
    if (over_) {
        throw *over_;
    }
    supervisor_.wait(link_.poll_fd(), 0);
    std::optional<Death> io_death;
    for (const Death& death : supervisor_.take_deaths()) {
        if (io_.used && io_.used->name() == death.name) {
            io_death = death;
        } else if (io_.prepared && io_.prepared->name() == death.name) {
            io_.prepared.reset();  // The next start_io() tries again and reports the failure.
            io_.early_hello.reset();
        } else if (!was_dismissed(death)) {
            fail(death.code(), describe(death));
        }
    }
    if (const int signal = supervisor_.take_interrupt(); signal == SIGINT && can_be_cancelled_) {
        cancel();
    } else if (signal != 0) {
        give_in(interruption(signal));
    }
    ask_watcher();
    if (io_death) {
        io_.used->endpoint.clear();
        dismiss_io();
        throw RequestError(io_.death_code, describe(*io_death));
    }
    if (record_failure_) {
        const std::string text = *std::exchange(record_failure_, std::nullopt);
        throw RequestError(ExitCode::failed, "recording stops: " + text);
    }
}

void Launcher::fail(int code, const std::string& text) {
    give_in({code, text + traces_of_failure()});
}

void Launcher::give_in(const MachineError& cause) {
    over_ = cause;
    bring_down(launched_ ? failed_drain_ms : 0);  // Before Go, no node has work to finish.
    throw cause;
}

void Launcher::shutdown() {
    if (over_) {
        throw *over_;
    }
    dismiss_io();
    check_health();  // An earlier event is the cause, not a second Ctrl-C.
    over_.emplace(1, "the machine has been shut down");
    if (const std::optional<MachineError> cause = bring_down(options_.drain_ms)) {
        throw *cause;
    }
}

std::optional<MachineError> Launcher::bring_down(int grace_ms) {
    drop_prepared_io();
    for (const RosterEntry& node : roster_) {
        if (node.id != bus::host_id && !node.endpoint.empty()) {
            link_.send(node.id, shutdown_message());
        }
    }
    std::optional<MachineError> cause;
    std::size_t step = 0;
    std::int64_t deadline_ms = now_ms() + grace_ms;
    for (std::vector<std::string> left; !(left = supervisor_.running()).empty();) {
        const bool patient = step == steps.size();
        const std::int64_t left_ms =
            patient ? -1 : std::max<std::int64_t>(0, deadline_ms - now_ms());
        supervisor_.wait(link_.poll_fd(), static_cast<int>(left_ms));
        discard_messages();
        for (const Death& death : supervisor_.take_deaths()) {
            const bool expected = death.signal == 0 && death.exit_code == 0;
            if (!cause && !expected && !was_dismissed(death)) {
                cause.emplace(death.code(), describe(death));
            }
        }
        left = supervisor_.running();
        const int signal = supervisor_.take_interrupt();
        if (!patient && !left.empty() && (signal != 0 || now_ms() >= deadline_ms)) {
            if (!cause && signal != 0) {
                cause = interruption(signal);  // The signal causes the deaths that follow.
            }
            if (launched_ || step > 0) {
                fmt::print(stderr, "still running: {}; sending SIG{}\n", fmt::join(left, ", "),
                           sigabbrev_np(steps[step].signal));
            }
            supervisor_.kill_all(steps[step].signal);
            deadline_ms = now_ms() + steps[step].patience_ms;
            ++step;
        }
    }
    const std::optional<MachineError> unwritten = close_trace();
    return cause ? cause : unwritten;
}

void Launcher::discard_messages() {
    for (bool more = true; more;) {
        try {
            const std::optional<bus::Message> message = link_.receive();
            more = message.has_value();
            if (message) {
                note(*message);  // The last messages belong to the trace.
            }
        } catch (const std::runtime_error&) {
            // The machine is ending already.
        }
    }
}

}  // namespace pxpl5::host
