#include "host/serve/classroom/front.hpp"

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
#include <fstream>
#include <memory>
#include <system_error>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/kernel/owned_descriptor.hpp"
#include "host/base/kernel/program_folder.hpp"
#include "host/base/standard_streams.hpp"
#include "host/base/state_folder.hpp"
#include "host/machine/port.hpp"
#include "host/machine/run_folder.hpp"
#include "host/machine/sessions/session_list.hpp"
#include "host/machine/supervisor.hpp"
#include "host/serve/classroom/classroom.hpp"
#include "host/serve/job/job_script.hpp"
#include "host/serve/limits/memory_limit.hpp"
#include "host/serve/limits/time_limit.hpp"
#include "host/serve/server/greeter.hpp"

namespace pxpl5::host::serve {

namespace {

constexpr const char* usual_idle_limit = "30";  // Minutes.
constexpr int end_ms = 20'000;
constexpr std::array<std::string_view, 4> options_of_class{"--sessions", "--port", "--idle-limit",
                                                           "--memory-limit"};

/// Memory that this computer could give to programs now.
std::uint64_t free_memory() {
    std::ifstream file("/proc/meminfo");
    for (std::string name; file >> name;) {
        constexpr std::uint64_t bytes_per_kib = 1024;
        std::uint64_t kib = 0;
        if (name == "MemAvailable:" && file >> kib) {
            return kib * bytes_per_kib;
        }
    }
    return 0;
}

/// The last line of a session's log, as a sentence.
std::string sentence_of_end(const Death& death, const std::filesystem::path& log) {
    std::string text = last_words(log);
    for (const std::string_view level : {"error: ", "warning: ", "note: "}) {
        text = text.starts_with(level) ? text.substr(level.size()) : text;
    }
    // After an end in order, the last line may be about something else.
    if (text.empty() ||
        (death.signal == 0 && death.exit_code == 0 && !text.starts_with(idle_end_words))) {
        text = death.signal == 0 && death.exit_code == 0 ? "It was asked to end" : death.text();
    }
    text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
    return text.ends_with('.') ? text : text + ".";
}

class Front {
  public:
    Front(const ClassOptions& options, const ServerOptions& server);
    void run();

  private:
    /// Readable when a session is wanted, or SIGUSR1 has come.
    int alarm() const { return alarm_.fd; }
    void start(const WantedSession& wanted);
    void tell(int number, const std::string& what) const;
    void note_ends();
    void end_all();
    std::filesystem::path log_of(const std::string& name) const { return logs_.path() / name; }

    const ClassOptions& options_;
    const EndSignal end_signal_;
    const OwnedDescriptor wanted_, alarm_;
    const TemporaryFolder logs_;
    std::vector<std::string> words_;
    std::string idle_limit_;
    std::uint64_t memory_limit_;
    Supervisor supervisor_;
    Classroom classroom_;
    std::unique_ptr<Greeter> greeter_;
    bool has_fixed_ports_;
};

Front::Front(const ClassOptions& options, const ServerOptions& server)
    : options_(options),
      wanted_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      alarm_(epoll_create1(EPOLL_CLOEXEC)),
      logs_("pxpl5-class"),
      words_(words_without(options.words, options_of_class)),
      idle_limit_(options.idle_limit.empty() ? usual_idle_limit : options.idle_limit),
      memory_limit_(options.memory_limit != 0
                        ? options.memory_limit
                        : free_memory() / static_cast<std::uint64_t>(options.sessions)),
      classroom_(
          options.sessions, [this](pid_t pid) { return facts_of_process(options_.run_base, pid); },
          [this] { (void)eventfd_write(wanted_.fd, 1); }),
      greeter_(std::make_unique<Greeter>(server, classroom_)),
      has_fixed_ports_(server.port != 0) {
    for (const int each : {wanted_.fd, end_signal_.fd()}) {
        epoll_event event{};
        event.events = EPOLLIN;
        if (epoll_ctl(alarm_.fd, EPOLL_CTL_ADD, each, &event) != 0) {
            throw std::system_error(errno, std::generic_category(), "cannot wait for students");
        }
    }
}

void Front::tell(int number, const std::string& what) const {
    fmt::print("session {} {} ({} of {} taken)\n", number, what, classroom_.taken(),
               options_.sessions);
    std::fflush(stdout);
}

void Front::start(const WantedSession& wanted) {
    ProcessCommand command;
    command.name = fmt::format("session {}", wanted.number);
    command.program = program_folder() / "pxpl5";
    command.arguments = {"serve", fmt::format("--end-with={}", getpid()),
                         fmt::format("--class-port={}", greeter_->port()),
                         "--idle-limit=" + idle_limit_,
                         fmt::format("--memory-limit={}B", memory_limit_)};
    if (has_fixed_ports_) {
        command.arguments.push_back(fmt::format("--port={}", greeter_->port() + wanted.place));
    }
    command.arguments.insert(command.arguments.end(), words_.begin(), words_.end());
    command.log = log_of(command.name);
    command.new_log = true;
    try {
        classroom_.started(wanted.number, supervisor_.spawn(command));
        tell(wanted.number, "starts");
    } catch (const MachineError& error) {
        classroom_.ended(wanted.number, fmt::format("{}.", error.what()));
        fmt::print(stderr, "error: {}\n", error.what());
    }
}

void Front::note_ends() {
    for (const Death& death : supervisor_.take_deaths()) {
        const int number = std::stoi(death.name.substr(death.name.find(' ') + 1));
        const std::string why = sentence_of_end(death, log_of(death.name));
        classroom_.ended(number, why);
        tell(number, fmt::format("has ended: {}", printable(why)));
        std::error_code ignored;
        std::filesystem::remove(log_of(death.name), ignored);
    }
}

void Front::run() {
    fmt::print(
        "pxpl5 serves a class: {} session{} at the same time, each with a machine of its "
        "own\nopen      {}\neach ends after {} without use, or when it uses more than {} "
        "of memory\nCtrl-C ends all\n",
        options_.sessions, options_.sessions == 1 ? "" : "s", greeter_->url(),
        duration_text(parse_duration("--idle-limit", idle_limit_)), gib_text(memory_limit_));
    std::fflush(stdout);
    while (supervisor_.take_interrupt() == 0) {
        if (supervisor_.wait_input(-1, alarm())) {
            eventfd_t ignored = 0;
            (void)eventfd_read(wanted_.fd, &ignored);
            if (end_signal_.take()) {
                supervisor_.kill_all(SIGUSR1);  // Each session warns its browser.
            }
        }
        if (classroom_.is_lost()) {
            throw RequestError(ExitCode::unavailable,
                               "the web server of the class cannot go on: its service of "
                               "connections has failed");
        }
        note_ends();
        for (const WantedSession& wanted : classroom_.take_wanted()) {
            start(wanted);
        }
    }
    end_all();
}

void Front::end_all() {
    greeter_.reset();
    supervisor_.kill_all(SIGTERM);
    const std::int64_t limit_ms = now_ms() + end_ms;
    while (!supervisor_.running().empty() && now_ms() < limit_ms &&
           supervisor_.take_interrupt() == 0) {
        supervisor_.wait(-1, static_cast<int>(std::max<std::int64_t>(limit_ms - now_ms(), 0)));
        supervisor_.take_deaths();
    }
}

}  // namespace

int serve_class(const ClassOptions& options, const ServerOptions& server) {
    Front(options, server).run();
    return 0;
}

}  // namespace pxpl5::host::serve
