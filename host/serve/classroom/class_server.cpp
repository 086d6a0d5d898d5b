#include "host/serve/classroom/class_server.hpp"

#include <fmt/core.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <map>
#include <memory>
#include <system_error>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/kernel/owned_descriptor.hpp"
#include "host/base/kernel/program_folder.hpp"
#include "host/base/kernel/standard_streams.hpp"
#include "host/base/state_folder.hpp"
#include "host/machine/port.hpp"
#include "host/machine/processes/supervisor.hpp"
#include "host/machine/run_folder.hpp"
#include "host/machine/sessions/session_list.hpp"
#include "host/serve/classroom/classroom.hpp"
#include "host/serve/job/job_script.hpp"
#include "host/serve/limits/memory_limit.hpp"
#include "host/serve/limits/time_limit.hpp"
#include "host/serve/server/class_page.hpp"

namespace pxpl5::host::serve {

namespace {

constexpr const char* usual_idle_limit = "30";  // Minutes.
constexpr int end_ms = 20'000;
/// A session writes its address to its run folder, which may lie on a network file system.
constexpr int look_ms = 200;
constexpr int last_port = 65'535;
/// Few students use their machines at the same moment.
constexpr int busy_share = 4;
constexpr std::array<std::string_view, 5> options_of_class{"--sessions", "--port", "--idle-limit",
                                                           "--memory-limit", "--time-limit"};

void check(const ClassOptions& options, const ServerOptions& server) {
    if (server.port != 0 && server.port + options.sessions > last_port) {
        throw RequestError(
            ExitCode::usage,
            fmt::format("--port {} with --sessions {}: the sessions need the ports {} to {}, and "
                        "the last port is {}. Give a lower port",
                        server.port, options.sessions, server.port + 1,
                        server.port + options.sessions, last_port));
    }
}

/// The limit of each session in bytes; 0, which is none, if the free memory is unknown.
std::uint64_t memory_limit_of(const ClassOptions& options) {
    if (options.memory_limit != 0) {
        return options.memory_limit;
    }
    const std::optional<std::uint64_t> free = free_memory();
    const auto sessions = static_cast<std::uint64_t>(options.sessions);
    return free ? std::max<std::uint64_t>(*free / sessions, 1) : 0;
}

/// The last line that begins with "error: ", without this word; empty if there is none.
std::string error_in(const std::filesystem::path& log) {
    constexpr std::string_view word = "error: ";
    std::ifstream file(log);
    std::string found;
    for (std::string line; std::getline(file, line);) {
        found = line.starts_with(word) ? line.substr(word.size()) : found;
    }
    return found;
}

/// Why a session has ended.
std::string reason_of(const Death& death, const std::filesystem::path& log) {
    if (death.signal == 0 && death.exit_code == 0) {
        constexpr std::string_view word = "note: ";
        const std::string last = last_words(log);
        return last.starts_with(fmt::format("{}{}", word, idle_end_words))
                   ? last.substr(word.size())
                   : "the session was asked to end, by 'pxpl5 sessions end' or a signal";
    }
    const std::string error = death.signal == 0 ? error_in(log) : "";
    return error.empty() ? death.text() : error;
}

/// A reason as a sentence. A file's name at its begin keeps its letters.
std::string sentence(std::string text) {
    if (text.starts_with("the session")) {
        text.front() = 'T';
    }
    return with_stop(std::move(text));
}

class ClassServer {
  public:
    ClassServer(const ClassOptions& options, const ServerOptions& server);
    /// Ends the sessions.
    ~ClassServer();
    ClassServer(const ClassServer&) = delete;
    ClassServer& operator=(const ClassServer&) = delete;

    void run();

  private:
    struct Running {
        pid_t pid = 0;
        bool is_ready = false;
    };

    /// Waits until something has happened, and handles it.
    void step();
    void start(const WantedSession& wanted);
    void look_for_addresses();
    void pass_on_end_signal();
    void note_ends();
    bool start_first();
    void print_start() const;
    void print(int number, const std::string& what) const;
    std::vector<std::string> arguments_of(const WantedSession& wanted) const;
    std::filesystem::path log_of(const std::string& name) const { return logs_.path() / name; }

    const ClassOptions& options_;
    const EndSignal end_signal_;
    const OwnedDescriptor wanted_, alarm_;
    const TemporaryFolder logs_;
    std::vector<std::string> words_;
    std::string idle_limit_;
    std::int64_t idle_s_;
    std::uint64_t memory_limit_;
    bool has_end_signal_ = false;
    Supervisor supervisor_;
    std::map<int, Running> running_;  ///< By number.
    std::string first_error_;         ///< The error of a first session that could not start.
    ExitCode first_code_ = ExitCode::failed;  ///< Its exit code.
    Classroom classroom_;
    std::unique_ptr<ClassPage> page_;
    bool has_fixed_ports_;
};

ClassServer::ClassServer(const ClassOptions& options, const ServerOptions& server)
    : options_(options),
      wanted_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      alarm_(epoll_create1(EPOLL_CLOEXEC)),
      logs_(class_folder),
      words_(words_without(options.words, options_of_class)),
      idle_limit_(options.idle_limit.empty() ? usual_idle_limit : options.idle_limit),
      idle_s_(parse_duration("--idle-limit", idle_limit_)),
      memory_limit_(memory_limit_of(options)),
      classroom_(options.sessions, [this] { (void)eventfd_write(wanted_.fd, 1); }),
      page_(std::make_unique<ClassPage>(server, classroom_)),
      has_fixed_ports_(server.port != 0) {
    for (const int each : {wanted_.fd, end_signal_.fd()}) {
        epoll_event event{};
        event.events = EPOLLIN;
        if (epoll_ctl(alarm_.fd, EPOLL_CTL_ADD, each, &event) != 0) {
            throw std::system_error(errno, std::generic_category(), "cannot wait for browsers");
        }
    }
}

ClassServer::~ClassServer() {
    page_.reset();
    supervisor_.kill_all(SIGTERM);
    const std::int64_t limit_ms = now_ms() + end_ms;
    while (!supervisor_.running().empty() && now_ms() < limit_ms &&
           supervisor_.take_interrupt() == 0) {
        supervisor_.wait(-1, static_cast<int>(std::max<std::int64_t>(limit_ms - now_ms(), 0)));
        supervisor_.take_deaths();
    }
}

void ClassServer::print(int number, const std::string& what) const {
    fmt::print("session {} {} ({} of {} taken)\n", number, printable(what), classroom_.taken(),
               options_.sessions);
    std::fflush(stdout);
}

std::vector<std::string> ClassServer::arguments_of(const WantedSession& wanted) const {
    std::vector<std::string> arguments = {"serve", fmt::format("--end-with={}", getpid()),
                                          fmt::format("--class-port={}", page_->port()),
                                          "--idle-limit=" + idle_limit_};
    if (memory_limit_ != 0) {
        arguments.push_back(fmt::format("--memory-limit={}B", memory_limit_));
    }
    if (has_fixed_ports_) {
        arguments.push_back(fmt::format("--port={}", page_->port() + wanted.place));
    }
    if (options_.end_s) {
        const std::int64_t left_s = std::max<std::int64_t>(*options_.end_s - std::time(nullptr), 1);
        // Minutes and seconds: parse_duration() takes numbers up to a million.
        arguments.push_back(fmt::format("--time-limit={}:{}", left_s / 60, left_s % 60));
    }
    if (options_.fitted_cores != 0) {
        const int cores = std::clamp(busy_share * options_.fitted_cores / options_.sessions, 1,
                                     options_.fitted_cores);
        arguments.push_back(fmt::format("--set=gp.count={}", cores));
        arguments.push_back(fmt::format("--set=renderer.count={}", cores));
    }
    arguments.insert(arguments.end(), words_.begin(), words_.end());
    return arguments;
}

void ClassServer::start(const WantedSession& wanted) {
    ProcessCommand command;
    command.name = fmt::format("session {}", wanted.number);
    command.program = program_folder() / "pxpl5";
    command.arguments = arguments_of(wanted);
    command.log = log_of(command.name);
    command.new_log = true;
    try {
        running_[wanted.number].pid = supervisor_.spawn(command);
    } catch (const MachineError& error) {
        running_.erase(wanted.number);
        first_error_ = error.what();
        classroom_.ended(wanted.number, sentence(error.what()));
        print_error(error.what(), 0);
    }
}

void ClassServer::look_for_addresses() {
    for (auto& [number, session] : running_) {
        if (session.is_ready) {
            continue;
        }
        const auto found = session_of_process(options_.run_base, session.pid);
        if (found && !found->facts.url.empty()) {
            session.is_ready = true;
            classroom_.ready(number, found->facts.url);
            print(number, fmt::format("is ready: {}", found->name));
            if (has_end_signal_) {
                kill(session.pid, SIGUSR1);
            }
        }
    }
}

/// A session warns its browser. One that only starts gets the signal when it is ready: before that,
/// the signal would end it.
void ClassServer::pass_on_end_signal() {
    has_end_signal_ = true;
    for (const auto& [number, session] : running_) {
        if (session.is_ready) {
            kill(session.pid, SIGUSR1);
        }
    }
}

void ClassServer::note_ends() {
    for (const Death& death : supervisor_.take_deaths()) {
        const int number = std::stoi(death.name.substr(death.name.find(' ') + 1));
        const std::string why = reason_of(death, log_of(death.name));
        running_.erase(number);
        first_error_ = why;
        first_code_ = death.signal == 0 && death.exit_code != 0
                          ? static_cast<ExitCode>(death.exit_code)
                          : ExitCode::failed;
        classroom_.ended(number, sentence(why));
        print(number, "has ended: " + sentence(why));
        std::error_code ignored;
        std::filesystem::remove(log_of(death.name), ignored);
    }
}

void ClassServer::step() {
    const bool is_starting =
        std::ranges::any_of(running_, [](const auto& each) { return !each.second.is_ready; });
    if (supervisor_.wait_input(-1, alarm_.fd, is_starting ? look_ms : -1)) {
        eventfd_t ignored = 0;
        (void)eventfd_read(wanted_.fd, &ignored);
        if (end_signal_.take()) {
            pass_on_end_signal();
        }
    }
    if (classroom_.has_failed()) {
        throw RequestError(ExitCode::unavailable,
                           "the web server of the class cannot go on: its service of connections "
                           "has failed");
    }
    note_ends();
    for (const WantedSession& wanted : classroom_.take_wanted()) {
        start(wanted);
    }
    look_for_addresses();
}

/// Returns false if the user has ended the program meanwhile.
bool ClassServer::start_first() {
    classroom_.want_one();
    do {
        step();
        if (running_.empty()) {
            throw RequestError(first_code_,
                               "the first session of the class cannot start: " + first_error_);
        }
        if (supervisor_.take_interrupt() != 0) {
            return false;
        }
    } while (!running_.begin()->second.is_ready);
    return true;
}

void ClassServer::print_start() const {
    std::string limits;
    if (idle_s_ != 0) {
        limits = fmt::format("after {} without use", duration_text(idle_s_));
    }
    if (memory_limit_ != 0) {
        limits += fmt::format("{}when it uses more than {} of memory",
                              limits.empty() ? "" : ", or ", gib_text(memory_limit_));
    }
    fmt::print(
        "pxpl5 serves a class: {} session{} at the same time, each with a machine of its "
        "own\nopen      {}\n",
        options_.sessions, options_.sessions == 1 ? "" : "s", page_->url());
    if (!limits.empty()) {
        fmt::print("each ends {}\n", limits);
    }
    fmt::print("Ctrl-C ends all\n");
    std::fflush(stdout);
}

void ClassServer::run() {
    if (!start_first()) {
        return;
    }
    print_start();
    while (supervisor_.take_interrupt() == 0) {
        step();
    }
}

}  // namespace

int serve_class(const ClassOptions& options, const ServerOptions& server) {
    check(options, server);
    ClassServer(options, server).run();
    return 0;
}

}  // namespace pxpl5::host::serve
