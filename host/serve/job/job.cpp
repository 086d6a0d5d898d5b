#include "host/serve/job/job.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <pthread.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <system_error>

#include "host/base/error.hpp"
#include "host/base/kernel/program_folder.hpp"
#include "host/base/kernel/run_program.hpp"
#include "host/base/kernel/standard_streams.hpp"
#include "host/machine/sessions/session_list.hpp"
#include "host/serve/director/shell_word.hpp"
#include "host/serve/job/job_state.hpp"

namespace pxpl5::host::serve {

namespace {

using std::chrono::milliseconds, std::chrono::seconds, std::chrono::steady_clock;

constexpr int slurm_ms = 60'000;  // Slurm's commands try for some time if the controller is busy.
// Many users ask one controller: the longer a job waits, the less often this program asks.
constexpr milliseconds shortest_pause{1000}, longest_pause{15'000}, pause_while_up{5000};
constexpr int waits_per_pause = 10;
// A network file system shows new files of other computers after up to a minute.
constexpr seconds usual_start{120};

/// Ctrl-C and SIGTERM, for this thread to read instead of dying.
class EndWish {
  public:
    EndWish() {
        sigset_t signals;
        sigemptyset(&signals);
        sigaddset(&signals, SIGINT);
        sigaddset(&signals, SIGTERM);
        pthread_sigmask(SIG_BLOCK, &signals, &before_);
        fd_ = signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK);
        if (fd_ < 0) {
            throw std::system_error(errno, std::generic_category(), "cannot wait for SIGINT");
        }
    }
    ~EndWish() {
        close(fd_);
        pthread_sigmask(SIG_SETMASK, &before_, nullptr);
    }
    EndWish(const EndWish&) = delete;
    EndWish& operator=(const EndWish&) = delete;

    /// Readable when a signal has come.
    int fd() const { return fd_; }
    /// Returns whether a signal has come, which wait() then returns.
    bool has_come() const {
        pollfd polled{fd_, POLLIN, 0};
        return poll(&polled, 1, 0) > 0;
    }
    /// Waits for a signal. Returns its number, or 0 after `limit`.
    int wait(milliseconds limit) const {
        pollfd polled{fd_, POLLIN, 0};
        const steady_clock::time_point end = steady_clock::now() + limit;
        int ready = -1;
        do {
            const auto left = std::chrono::ceil<milliseconds>(end - steady_clock::now());
            ready = poll(&polled, 1, static_cast<int>(std::max<long>(left.count(), 0)));
        } while (ready < 0 && errno == EINTR);
        signalfd_siginfo signal{};
        return ready > 0 && read(fd_, &signal, sizeof signal) == sizeof signal
                   ? static_cast<int>(signal.ssi_signo)
                   : 0;
    }

  private:
    sigset_t before_{};
    int fd_;
};

std::string first_line(const std::string& text) {
    return text.substr(0, text.find('\n'));
}

RequestError refused(const std::string& program, const ProgramEnd& end, const std::string& remedy) {
    return {ExitCode::unavailable,
            end.is_in_time ? fmt::format("{} has failed with code {}: {} {}", program, end.code,
                                         with_stop(first_line(end.errors)), remedy)
                           : fmt::format("{} has not answered within {} s. {}", program,
                                         slurm_ms / 1000, remedy)};
}

SubmittedJob submit(const JobOptions& job, const std::string& time_limit) {
    const std::string program = (program_folder() / "pxpl5").string();
    const ProgramEnd end =
        run_program(sbatch_words(job, time_limit), job_script(job, program), slurm_ms);
    if (end.code != 0) {
        throw refused("sbatch", end,
                      end.is_in_time ? "No job was submitted"
                                     : "Look with 'squeue --me' whether the job was submitted");
    }
    const std::optional<SubmittedJob> submitted = parse_submitted(end.out);
    if (!submitted) {
        throw RequestError(
            ExitCode::unavailable,
            fmt::format("sbatch has printed '{}', whose last line is no job id such as 12 or "
                        "12;cluster. Look with 'squeue --me' whether the job was submitted",
                        end.out.substr(0, end.out.find_last_not_of('\n') + 1)));
    }
    return *submitted;
}

void cancel(const SubmittedJob& job) {
    const std::vector<std::string> words = slurm_words(job, {"scancel"});
    const ProgramEnd end = run_program(words, "", slurm_ms);
    if (end.code != 0) {
        throw refused("scancel", end,
                      fmt::format("Job {} may still run: '{}'", job.id, fmt::join(words, " ")));
    }
}

/// The last lines of a file, for an error.
std::string end_of(const std::string& path) {
    constexpr std::streamoff most_bytes = 2000;
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    // -1 for a file that has no end, or does not exist.
    const std::streamoff size = std::max<std::streamoff>(file.tellg(), 0);
    std::string text(static_cast<std::size_t>(std::min(size, most_bytes)), '\0');
    file.seekg(size - static_cast<std::streamoff>(text.size()));
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    return text.empty() ? fmt::format("Its output {} is empty", path)
                        : fmt::format("The end of its output {}:\n{}", path, text);
}

/// Follows the job, and says what changes.
class Follower {
  public:
    Follower(SubmittedJob job, std::filesystem::path base)
        : job_(std::move(job)), base_(std::move(base)) {}

    /// Looks once, and says what is new. A signal ends the look.
    void look(const EndWish& end_wish);
    bool has_ended() const { return state_.phase == JobState::Phase::has_ended; }
    bool is_up() const { return is_up_; }
    /// The time until the next look.
    milliseconds pause() const;
    /// Prints where the session is saved, and how the job has ended. Throws RequestError
    /// (unavailable) if that is not a regular end.
    void tell_end() const;

  private:
    void say(const std::string& sentence);
    /// Forgets the session of a job that waits again, after a computer has failed.
    void begin_again();
    void look_for_session();

    SubmittedJob job_;
    std::filesystem::path base_;
    JobState state_;
    std::string said_;
    std::optional<steady_clock::time_point> runs_since_;
    std::filesystem::path folder_;       ///< The run folder of the session, once it exists.
    std::filesystem::path past_folder_;  ///< The folder before the job waited again.
    bool is_up_ = false, has_missed_session_ = false;
    steady_clock::time_point begin_ = steady_clock::now();
};

void Follower::say(const std::string& sentence) {
    if (sentence != said_) {
        said_ = sentence;
        fmt::print("job {} {}\n", job_.id, printable(sentence));
        std::fflush(stdout);  // Pipes are not line-buffered.
    }
}

void Follower::look(const EndWish& end_wish) {
    const ProgramEnd end =
        run_program(slurm_words(job_, {"scontrol", "show", "job"}), "", slurm_ms, end_wish.fd());
    if (end_wish.has_come()) {
        return;
    }
    const bool is_forgotten = end.errors.find("Invalid job id") != std::string::npos;
    if (end.code != 0 && !is_forgotten) {
        say(fmt::format("cannot be asked for: scontrol does not answer ({})",
                        end.is_in_time ? first_line(end.errors) : "for a minute"));
        return;
    }
    JobState now = parse_job_state(end.out);
    now.output = now.output.empty() ? state_.output : now.output;
    state_ = std::move(now);
    if (state_.phase != JobState::Phase::runs) {
        if (!has_ended()) {
            begin_again();
            say(sentence_of(state_));
        }
        return;
    }
    const bool starts = !is_up_ && state_.name == "RUNNING";
    say(sentence_of(state_) + (starts ? ". The machine starts" : ""));
    runs_since_ = runs_since_.value_or(steady_clock::now());
    if (!is_up_) {
        look_for_session();
    }
}

void Follower::begin_again() {
    if (!runs_since_) {
        return;
    }
    past_folder_ = folder_;  // Another computer cannot see that its session has ended.
    runs_since_.reset();
    is_up_ = has_missed_session_ = false;
    begin_ = steady_clock::now();
}

void Follower::look_for_session() {
    const std::vector<RunningSession> sessions = running_sessions(base_);
    const auto found = std::ranges::find_if(sessions, [this](const RunningSession& each) {
        return each.job == job_.id && (past_folder_.empty() || each.folder != past_folder_);
    });
    if (found == sessions.end()) {
        if (!has_missed_session_ && steady_clock::now() - *runs_since_ > usual_start) {
            has_missed_session_ = true;
            print_notice(
                "warning",
                fmt::format("job {} runs, but no session of it is in {}. All computers of the "
                            "job must share this folder; --run-folder names another",
                            job_.id, base_.string()));
        }
        return;
    }
    folder_ = found->folder;
    if (found->facts.url.empty()) {
        return;
    }
    is_up_ = true;
    fmt::print("open      {}\nto watch  {}\n", printable(found->facts.url),
               printable(found->facts.watch_url));
    if (!found->facts.tunnel.empty()) {
        fmt::print("from another computer: {}, then open the same address there\n",
                   printable(found->facts.tunnel));
    }
    fmt::print("Ctrl-C ends job {0}. It goes on if this terminal closes: pxpl5 sessions show {0}\n",
               job_.id);
    std::fflush(stdout);
}

milliseconds Follower::pause() const {
    if (state_.phase == JobState::Phase::runs) {
        return is_up_ ? pause_while_up : shortest_pause;
    }
    const auto waited = std::chrono::ceil<milliseconds>(steady_clock::now() - begin_);
    return std::clamp(waited / waits_per_pause, shortest_pause, longest_pause);
}

void Follower::tell_end() const {
    const bool is_regular = state_.name.empty() || state_.name == "COMPLETED" ||
                            state_.name == "COMPLETING" || state_.name == "CANCELLED" ||
                            state_.name == "TIMEOUT";
    if (const std::string saved = folder_.empty() ? "" : read_note(folder_).saved; !saved.empty()) {
        fmt::print("the session is saved in {}. Open it again with: pxpl5 serve --session {}\n",
                   printable(saved), printable(shell_word(saved)));
        std::fflush(stdout);
    }
    if (!is_up_ || !is_regular) {
        throw RequestError(
            ExitCode::unavailable,
            fmt::format("job {} {}{}. {}", job_.id, sentence_of(state_),
                        is_up_ ? "" : ", before its page was up", end_of(state_.output)));
    }
    fmt::print("job {} {}\n", job_.id, printable(sentence_of(state_)));
}

}  // namespace

bool is_submitted(const JobOptions& job, const ClusterSettings& cluster) {
    const char* const own_job = std::getenv("SLURM_JOB_ID");
    const bool is_counted = !cluster.computers.empty() || cluster.wait > 0;
    if (cluster.engine == Engine::slurm && own_job == nullptr && !is_counted) {
        return true;
    }
    if (job.nodes > 0 || !job.sbatch.empty()) {
        throw RequestError(
            ExitCode::usage,
            fmt::format("--nodes and --sbatch-option are for a job that serve submits, but {}. "
                        "Leave them out, or use --engine slurm alone and outside of a job",
                        own_job != nullptr ? fmt::format("this is job {} already", own_job)
                        : is_counted       ? "--computers or wait say what serve uses"
                                     : fmt::format("the engine is {}", enum_name(cluster.engine))));
    }
    return false;
}

int serve_in_job(const JobOptions& options, const std::filesystem::path& base,
                 const std::string& time_limit) {
    constexpr int signal_base = 128;
    const EndWish end_wish;  // Before the job exists: from then on Ctrl-C must cancel it.
    const SubmittedJob job = submit(options, time_limit);
    fmt::print("job {} is submitted. Ctrl-C cancels it\n", job.id);
    std::fflush(stdout);
    Follower follower(job, base);
    for (;;) {
        follower.look(end_wish);
        if (follower.has_ended()) {
            follower.tell_end();
            return 0;
        }
        if (const int signal = end_wish.wait(follower.pause()); signal != 0) {
            cancel(job);
            fmt::print("job {} is canceled\n", job.id);
            return follower.is_up() ? 0 : signal_base + signal;
        }
    }
}

}  // namespace pxpl5::host::serve
