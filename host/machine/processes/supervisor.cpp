#include "host/machine/processes/supervisor.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/epoll.h>
#include <unistd.h>
#include <uv.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <chrono>
#include <csignal>
#include <cstring>
#include <deque>
#include <functional>
#include <string_view>
#include <utility>

#include "host/machine/port.hpp"
#include "host/machine/processes/kept_signals.hpp"
#include "host/machine/processes/watch_signals.hpp"

namespace pxpl5::host {

namespace {

constexpr auto unavailable = static_cast<int>(ExitCode::unavailable);
constexpr std::size_t max_interrupts = 8;
constexpr int end_ms = 10'000;  // From SIGKILL to the end of a process.

std::string signal_name(int signal) {
    const char* name = sigabbrev_np(signal);
    return name != nullptr ? fmt::format("SIG{}", name) : "unknown";
}

struct Child {
    uv_process_t handle{};
    std::string name;
    bool running = false;
};

/// Throws MachineError for an error of libuv.
void check_uv(const char* what, int error) {
    if (error != 0) {
        throw MachineError(unavailable, fmt::format("cannot {}: {}", what, uv_strerror(error)));
    }
}

/// Pointers into `texts`, with the final null that exec needs.
std::vector<char*> pointers(std::vector<std::string>& texts) {
    std::vector<char*> result;
    for (std::string& text : texts) {
        result.push_back(text.data());
    }
    result.push_back(nullptr);
    return result;
}

/// This process's environment with `added`, which replaces entries of the same name.
std::vector<std::string> environment(const std::vector<std::string>& added) {
    std::vector<std::string> all = added;
    for (char** variable = environ; *variable != nullptr; ++variable) {
        const std::string_view text(*variable);
        const std::string_view key = text.substr(0, text.find('=') + 1);
        const bool replaced = std::any_of(added.begin(), added.end(), [key](const std::string& a) {
            return std::string_view(a).starts_with(key);
        });
        if (!replaced) {
            all.emplace_back(text);
        }
    }
    return all;
}

/// An open log whose first line names the program.
int open_log(const ProcessCommand& command, const std::vector<std::string>& arguments) {
    const int flags = O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC;
    const int fd = open(command.log.c_str(), flags | (command.new_log ? O_TRUNC : 0), 0600);
    if (fd < 0) {
        throw MachineError(unavailable,
                           fmt::format("{} cannot start: its log {} cannot be opened: {}",
                                       command.name, command.log.string(), std::strerror(errno)));
    }
    const std::string line = fmt::format(
        "{}: {}\n", command.name,
        command.log_arguments ? fmt::format("{}", fmt::join(arguments, " ")) : arguments.front());
    [[maybe_unused]] const ssize_t written = write(fd, line.data(), line.size());
    return fd;
}

}  // namespace

std::string Death::text() const {
    if (!why.empty()) {
        return why;
    }
    if (signal != 0) {
        return fmt::format("{} was killed by signal {} ({})", name, signal, signal_name(signal));
    }
    return fmt::format("{} ended with exit code {}", name, exit_code);
}

int Death::code() const {
    return signal != 0 ? 128 + signal : exit_code != 0 ? exit_code : unavailable;
}

MachineError interruption(int signal) {
    MachineError error(128 + signal, fmt::format("interrupted by SIG{}", sigabbrev_np(signal)));
    error.is_interruption = true;
    return error;
}

struct Supervisor::Parts {
    uv_loop_t loop{};
    EndSignals signals{};
    uv_timer_t timer{};
    uv_poll_t poll{};
    int poll_fd = -1;
    /// An epoll set with the input. libuv polls the set, because libuv would make the input
    /// non-blocking, and with it the terminal that stdout and other programs share.
    int input_set = epoll_create1(EPOLL_CLOEXEC);
    uv_poll_t input_poll{};
    std::vector<std::unique_ptr<Child>> children;
    std::vector<Death> deaths;
    std::deque<int> interrupts;  ///< At most max_interrupts.
    bool timer_fired = false, fd_readable = false, input_readable = false;

    void watch(int fd);
    void watch_signals();
    /// timeout_ms  -1: no limit.
    void run(int timeout_ms);
    void on_exit(Child& child, int exit_code, int signal);
    /// Waits until processes have ended, at most `most_ms`: the kernel may keep even a killed one.
    void run_until_ended(int most_ms, const std::function<bool()>& have_ended);
    void close_loop();
};

void Supervisor::Parts::watch(int fd) {
    if (fd < 0 || fd == poll_fd) {
        return;
    }
    assert(poll_fd == -1);  // The supervisor has one link.
    poll_fd = fd;
    check_uv("watch the ring", uv_poll_init(&loop, &poll, fd));
    poll.data = this;
    check_uv("watch the ring", uv_poll_start(&poll, UV_READABLE, [](uv_poll_t* handle, int, int) {
                 static_cast<Parts*>(handle->data)->fd_readable = true;
             }));
}

void Supervisor::Parts::watch_signals() {
    // The program's parent may have blocked it. No death would be noticed.
    sigset_t child_signal;
    sigemptyset(&child_signal);
    sigaddset(&child_signal, SIGCHLD);
    pthread_sigmask(SIG_UNBLOCK, &child_signal, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
    check_uv("watch signals", watch_end_signals(loop, signals, [](uv_signal_t* handle, int number) {
                 Parts& parts = *static_cast<Parts*>(handle->loop->data);
                 if (parts.interrupts.size() < max_interrupts) {
                     parts.interrupts.push_back(number);
                 }
             }));
}

void Supervisor::Parts::run(int timeout_ms) {
    if (timeout_ms == 0) {
        uv_run(&loop, UV_RUN_NOWAIT);
        return;
    }
    if (timeout_ms > 0) {
        uv_update_time(&loop);
        uv_timer_start(
            &timer,
            [](uv_timer_t* handle) {
                static_cast<Parts*>(handle->data)->timer_fired = true;
                // A timer of 0 ms fires before the loop polls, so the poll does not block.
                uv_stop(handle->loop);
            },
            static_cast<std::uint64_t>(timeout_ms), 0);
    }
    while (!timer_fired && !fd_readable && !input_readable && deaths.empty() &&
           interrupts.empty()) {
        uv_run(&loop, UV_RUN_ONCE);
    }
    uv_timer_stop(&timer);
}

void Supervisor::Parts::close_loop() {
    uv_walk(
        &loop,
        [](uv_handle_t* handle, void*) {
            if (uv_is_closing(handle) == 0) {
                uv_close(handle, nullptr);
            }
        },
        nullptr);
    uv_run(&loop, UV_RUN_DEFAULT);
    [[maybe_unused]] const int closed = uv_loop_close(&loop);
    assert(closed == 0);
    close(input_set);
}

void Supervisor::Parts::run_until_ended(int most_ms, const std::function<bool()>& have_ended) {
    timer_fired = false;
    uv_update_time(&loop);
    uv_timer_start(
        &timer, [](uv_timer_t* handle) { static_cast<Parts*>(handle->data)->timer_fired = true; },
        static_cast<std::uint64_t>(most_ms), 0);
    while (!timer_fired && !have_ended()) {
        uv_run(&loop, UV_RUN_ONCE);
    }
    uv_timer_stop(&timer);
}

void Supervisor::Parts::on_exit(Child& child, int exit_code, int signal) {
    child.running = false;
    deaths.push_back({child.name, exit_code, signal, {}});
    uv_close(reinterpret_cast<uv_handle_t*>(&child.handle), [](uv_handle_t* handle) {
        Parts& parts = *static_cast<Parts*>(handle->loop->data);
        std::erase_if(parts.children, [handle](const auto& c) {
            return reinterpret_cast<uv_handle_t*>(&c->handle) == handle;
        });
    });
}

Supervisor::Supervisor() : parts_(std::make_unique<Parts>()) {
    if (parts_->input_set < 0) {
        throw MachineError(unavailable,
                           fmt::format("cannot watch the input: {}", std::strerror(errno)));
    }
    check_uv("make an event loop", uv_loop_init(&parts_->loop));
    parts_->loop.data = parts_.get();
    try {
        check_uv("make a timer", uv_timer_init(&parts_->loop, &parts_->timer));
        parts_->timer.data = parts_.get();
        check_uv("watch the input",
                 uv_poll_init(&parts_->loop, &parts_->input_poll, parts_->input_set));
        parts_->input_poll.data = parts_.get();
        parts_->watch_signals();
        if (KeptSignals* const kept = KeptSignals::current()) {
            parts_->interrupts = kept->take();
        }
    } catch (...) {
        parts_->close_loop();
        throw;
    }
}

Supervisor::~Supervisor() {
    kill_all(SIGKILL);
    parts_->run_until_ended(end_ms, [this] { return running().empty(); });
    if (KeptSignals* const kept = KeptSignals::current()) {
        uv_run(&parts_->loop, UV_RUN_NOWAIT);
        kept->hand_over(parts_->interrupts);
    }
    parts_->close_loop();
}

int Supervisor::spawn(const ProcessCommand& command) {
    std::vector<std::string> arguments = {command.program.string()};
    arguments.insert(arguments.end(), command.arguments.begin(), command.arguments.end());
    std::vector<std::string> env = environment(command.env);
    const int log = open_log(command, arguments);
    std::vector<char*> argument_pointers = pointers(arguments), env_pointers = pointers(env);

    std::vector<int> descriptors = {-1, log, log};
    descriptors.insert(descriptors.end(), command.inherited.begin(), command.inherited.end());
    std::vector<uv_stdio_container_t> streams(descriptors.size());
    streams[0].flags = command.input < 0 ? UV_IGNORE : UV_INHERIT_FD;
    streams[0].data.fd = command.input;
    for (std::size_t i = 1; i < streams.size(); ++i) {
        streams[i].flags = UV_INHERIT_FD;
        streams[i].data.fd = descriptors[i];
    }
    uv_process_options_t options{};
    options.file = arguments[0].c_str();
    options.args = argument_pointers.data();
    options.env = env_pointers.data();
    options.flags = UV_PROCESS_DETACHED;  // Ctrl-C in the terminal reaches only the host.
    options.stdio = streams.data();
    options.stdio_count = static_cast<int>(streams.size());
    options.exit_cb = [](uv_process_t* handle, std::int64_t exit_code, int signal) {
        static_cast<Parts*>(handle->loop->data)
            ->on_exit(*static_cast<Child*>(handle->data), static_cast<int>(exit_code), signal);
    };

    auto child = std::make_unique<Child>();
    child->name = command.name;
    child->handle.data = child.get();
    const int error = uv_spawn(&parts_->loop, &child->handle, &options);
    close(log);
    if (error != 0) {
        // The handle is still part of the loop, which closes it later.
        Child& failed = *parts_->children.emplace_back(std::move(child));
        parts_->on_exit(failed, unavailable, 0);
        parts_->deaths.pop_back();
        throw MachineError(unavailable, fmt::format("{} cannot start: {}: {}", command.name,
                                                    arguments[0], uv_strerror(error)));
    }
    child->running = true;
    const int pid = child->handle.pid;
    parts_->children.push_back(std::move(child));
    if (command.core >= 0) {
        cpu_set_t cores;
        CPU_ZERO(&cores);
        CPU_SET(static_cast<std::size_t>(command.core), &cores);
        if (sched_setaffinity(pid, sizeof cores, &cores) != 0) {
            throw MachineError(
                unavailable, fmt::format("{} cannot run on core {}: {}", command.name, command.core,
                                         std::strerror(errno)));
        }
    }
    return pid;
}

void Supervisor::wait(int fd, int timeout_ms) {
    parts_->watch(fd);
    parts_->timer_fired = parts_->fd_readable = parts_->input_readable = false;
    parts_->run(timeout_ms);
}

bool Supervisor::wait_input(int fd, int input, int timeout_ms) {
    parts_->watch(fd);
    parts_->timer_fired = parts_->fd_readable = parts_->input_readable = false;
    epoll_event event{};
    event.events = EPOLLIN;
    if (epoll_ctl(parts_->input_set, EPOLL_CTL_ADD, input, &event) != 0) {
        return true;  // EPERM: a file on disk, or /dev/null; EBADF: closed.
    }
    uv_poll_start(&parts_->input_poll, UV_READABLE, [](uv_poll_t* handle, int, int) {
        static_cast<Parts*>(handle->data)->input_readable = true;
    });
    parts_->run(timeout_ms);
    uv_poll_stop(&parts_->input_poll);
    epoll_ctl(parts_->input_set, EPOLL_CTL_DEL, input, &event);
    return parts_->input_readable;
}

std::vector<Death> Supervisor::take_deaths() {
    return std::exchange(parts_->deaths, {});
}
int Supervisor::take_interrupt() {
    if (parts_->interrupts.empty()) {
        return 0;
    }
    const int signal = parts_->interrupts.front();
    parts_->interrupts.pop_front();
    return signal;
}

void Supervisor::forget_interrupt(int signal) {
    if (!parts_->interrupts.empty() && parts_->interrupts.front() == signal) {
        parts_->interrupts.pop_front();
    }
}

std::vector<std::string> Supervisor::running() const {
    std::vector<std::string> names;
    for (const auto& child : parts_->children) {
        if (child->running) {
            names.push_back(child->name);
        }
    }
    return names;
}

void Supervisor::kill_all(int signal) {
    for (const std::string& name : running()) {
        kill(name, signal);
    }
}

void Supervisor::kill(const std::string& name, int signal) {
    for (const auto& child : parts_->children) {
        if (child->running && child->name == name) {
            ::kill(-child->handle.pid, signal);  // The whole group, which may have ended.
        }
    }
}

void Supervisor::end(const std::string& name, int signal, int most_ms) {
    kill(name, signal);
    parts_->run_until_ended(most_ms, [&] {
        const std::vector<std::string> left = running();
        return std::find(left.begin(), left.end(), name) == left.end();
    });
}

std::int64_t now_ms() {
    using namespace std::chrono;
    return duration_cast<milliseconds>(steady_clock::now().time_since_epoch()).count();
}

}  // namespace pxpl5::host
