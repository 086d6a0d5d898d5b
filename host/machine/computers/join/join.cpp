#include "host/machine/computers/join/join.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/kernel/program_folder.hpp"
#include "host/base/kernel/socket_folder.hpp"
#include "host/base/kernel/standard_streams.hpp"
#include "host/base/state_folder.hpp"
#include "host/machine/computers/facts.hpp"
#include "host/machine/computers/join/key.hpp"
#include "host/machine/computers/join/letter.hpp"
#include "host/machine/computers/join/way.hpp"
#include "host/machine/computers/poll_set.hpp"
#include "host/machine/port.hpp"
#include "host/machine/processes/supervisor.hpp"
#include "ringbus/process/process.hpp"
#include "ringbus/pulse.hpp"
#include "ringbus/zmq/line.hpp"

namespace pxpl5::host {

namespace {

constexpr int lost_ms = 1000;       // From the loss of the line to the end of all processes.
constexpr int terminate_ms = 1000;  // From SIGTERM to SIGKILL.
constexpr int answer_ms = 10'000;   // For the host to answer, and for the key to come.
constexpr int again_ms = 250;       // Before this computer asks again.
constexpr int signal_code = 128;    // Plus the number of the signal: an exit code.
constexpr std::size_t max_measured_bytes = std::size_t{1} << 20;

bus::Credentials key_of(const JoinOptions& options) {
    return options.key_from_input   ? read_key_from_input(answer_ms)
           : !options.munge.empty() ? open_munge_credential(options.munge)
                                    : read_key_file(options.key_file);
}

std::string host_part(const std::string& endpoint) {
    return endpoint.substr(tcp.size(), endpoint.rfind(':') - tcp.size());
}

/// Standard error may be closed, for example with the connection of ssh.
void say_why(const std::string& text) {
    std::fputs(fmt::format("pxpl5 join: {}\n", printable(text)).c_str(), stderr);
}

/// One computer of a machine, between its first and its last letter.
class Joined {
  public:
    Joined(const Way& way, const bus::Credentials& credentials, bool watches_input);

    /// Introduces this computer. Throws MachineError if the host refuses it or does not answer.
    void introduce(const JoinOptions& options);
    int run();
    bool input_is_closed() const;
    /// True if the host wants this computer not to join again.
    bool is_released() const { return is_released_; }

  private:
    void wait(std::int64_t most_ms);
    /// Takes all letters. Returns false after Dismiss.
    bool take_letters();
    void start(const join::StartT& start);
    void send_beat();
    void send_ended();
    void send_file(const std::string& file);
    /// An exit code, if this program must end.
    std::optional<int> reason_to_end();
    void end_processes();
    std::filesystem::path files() const { return sockets_.path() / "files"; }
    template <typename WordT>
    void say(WordT word) {
        line_.send(packed_letter(std::move(word)));
    }

    SocketFolder sockets_{temporary_parent()};  ///< Also for logs and traces.
    Supervisor supervisor_;                     // After the folder, in which its processes write.
    Way way_;
    bus::Credentials credentials_;
    bus::Line line_;
    bool watches_input_;
    PollSet polled_;
    std::map<std::string, std::unique_ptr<bus::PulseCell>> cells_;
    int beat_ms_ = 250;
    std::int64_t beaten_ms_ = 0;
    std::optional<std::int64_t> lost_since_ms_;
    bool is_finished_ = false, is_released_ = false;
    std::string dismissal_;  ///< Why the host has ended this computer's part; empty in order.
};

Joined::Joined(const Way& way, const bus::Credentials& credentials, bool watches_input)
    : way_(way),
      credentials_(credentials),
      line_(way.address, credentials),
      watches_input_(watches_input),
      polled_({line_.poll_fd(), line_.event_fd()}) {
    sockets_.mark_as_used();
    std::filesystem::create_directories(files() / "traces");
}

void Joined::wait(std::int64_t most_ms) {
    supervisor_.wait(polled_.fd(), static_cast<int>(std::max<std::int64_t>(most_ms, 1)));
}

void Joined::introduce(const JoinOptions& options) {
    join::AskT ask = own_question(credentials_, options.name);
    ask.facts->address = way_.own;
    ask.facts->host_address = host_part(way_.address);
    ask.facts->folder = files().string();
    ask.facts->sockets = sockets_.path().string();
    say(std::move(ask));
    const std::int64_t end_ms = now_ms() + answer_ms;
    while (now_ms() < end_ms) {
        line_.is_connected();
        if (options.again && line_.was_lost()) {  // The question went to an earlier machine.
            line_.drop_unsent();
            throw MachineError(ExitCode::unavailable,
                               fmt::format("the host at {} has gone", way_.address));
        }
        if (line_.was_refused()) {
            throw MachineError(ExitCode::unavailable,
                               fmt::format("the host at {} does not accept this key: it is of "
                                           "another session, or another program listens there",
                                           way_.address));
        }
        while (const auto bytes = line_.receive()) {
            const join::LetterT letter = unpacked_letter(*bytes);
            const auto* answer = letter.word.AsAnswer();
            if (answer == nullptr) {
                continue;
            }
            if (!answer->refusal.empty()) {
                throw MachineError(ExitCode::unavailable,
                                   fmt::format("the host at {} refuses this computer: {}",
                                               way_.address, answer->refusal));
            }
            beat_ms_ = static_cast<int>(std::clamp<std::uint32_t>(answer->beat_ms, 10, 10'000));
            return;
        }
        if (const int signal = supervisor_.take_interrupt(); signal != 0) {
            throw join_interruption(signal);
        }
        wait(end_ms - now_ms());
    }
    throw MachineError(ExitCode::unavailable,
                       fmt::format("the host at {} takes connections, but has not answered within "
                                   "{} s",
                                   way_.address, answer_ms / 1000));
}

void Joined::start(const join::StartT& start) {
    ProcessCommand command;
    command.name = start.name;
    command.program = program_folder() / start.program;
    command.arguments = start.arguments;
    command.env = start.env;
    command.core = start.core;
    command.log = files() / (start.name + ".log");
    command.new_log = true;  // A node of an earlier machine may have had the name.
    std::error_code none;
    std::filesystem::remove(files() / ("traces/" + start.name + ".mcap"), none);
    try {
        if (!start.program.starts_with("pxpl5-") || start.program.find('/') != std::string::npos) {
            throw MachineError(ExitCode::unavailable,
                               fmt::format("{} is no program of a node", start.program));
        }
        const int credentials = bus::credentials_pipe(credentials_);
        const std::shared_ptr<void> closer(nullptr, [credentials](void*) { close(credentials); });
        command.inherited = {credentials};
        if (start.pulse_ms > 0) {
            auto& cell = cells_[start.name] = std::make_unique<bus::PulseCell>();
            command.inherited.push_back(cell->fd());
        }
        supervisor_.spawn(command);
        if (start.pulse_ms > 0) {
            cells_.at(start.name)->close_fd();
        }
    } catch (const std::exception& error) {
        cells_.erase(start.name);
        join::EndedT ended;
        ended.name = start.name;
        ended.exit_code = static_cast<int>(ExitCode::unavailable);
        ended.error = error.what();
        say(std::move(ended));
    }
}

bool Joined::take_letters() {
    while (const auto bytes = line_.receive()) {
        const join::LetterT letter = unpacked_letter(*bytes);
        const join::WordUnion& word = letter.word;
        if (const auto* order = word.AsStart()) {
            start(*order);
            send_beat();  // Starting many processes may take long.
        } else if (const auto* signal = word.AsSignal()) {
            supervisor_.kill(signal->name, signal->number);
        } else if (const auto* fetch = word.AsFetch()) {
            send_file(fetch->file);
        } else if (const auto* measure = word.AsMeasure()) {
            join::MeasuredT measured;
            measured.bytes.resize(std::min<std::size_t>(measure->bytes, max_measured_bytes));
            say(std::move(measured));
        } else if (const auto* dismiss = word.AsDismiss()) {
            is_finished_ = true;
            is_released_ = dismiss->is_released;
            dismissal_ = dismiss->reason;
        }
    }
    return !is_finished_;
}

void Joined::send_beat() {
    if (now_ms() - beaten_ms_ < beat_ms_) {
        return;
    }
    beaten_ms_ = now_ms();
    join::BeatT beat;
    for (const auto& [name, cell] : cells_) {
        const bus::PulseNumbers numbers = cell->numbers();
        auto pulse = std::make_unique<join::PulseT>();
        pulse->name = name;
        pulse->beats = numbers.beats;
        pulse->progress = numbers.progress;
        pulse->worked = numbers.worked;
        pulse->cpu_ns = numbers.cpu_ns;
        pulse->work = numbers.work;
        pulse->piece = numbers.place;
        beat.pulses.push_back(std::move(pulse));
    }
    say(std::move(beat));
}

void Joined::send_file(const std::string& file) {
    send_content(files(), file, [this](join::ContentT part) { say(std::move(part)); });
}

void Joined::send_ended() {
    for (const Death& death : supervisor_.take_deaths()) {
        cells_.erase(death.name);
        send_file(death.name + ".log");
        const std::string trace = "traces/" + death.name + ".mcap";
        if (std::filesystem::exists(files() / trace)) {
            send_file(trace);
        }
        join::EndedT ended;
        ended.name = death.name;
        ended.exit_code = death.exit_code;
        ended.signal = static_cast<std::uint16_t>(death.signal);
        say(std::move(ended));
    }
}

bool Joined::input_is_closed() const {
    std::array<char, 256> rest{};
    pollfd input{STDIN_FILENO, POLLIN, 0};
    return watches_input_ && poll(&input, 1, 0) > 0 &&
           read(STDIN_FILENO, rest.data(), rest.size()) <= 0;
}

std::optional<int> Joined::reason_to_end() {
    constexpr auto gone = static_cast<int>(ExitCode::unavailable);
    if (const int signal = supervisor_.take_interrupt(); signal != 0) {
        join::LeaveT leave;
        leave.reason = fmt::format("pxpl5 join got SIG{} there", sigabbrev_np(signal));
        say(std::move(leave));
        return signal_code + signal;
    }
    if (input_is_closed()) {
        say_why("standard input was closed: the host is gone");
        return gone;
    }
    if (line_.is_connected()) {
        lost_since_ms_.reset();
    } else {
        lost_since_ms_ = lost_since_ms_.value_or(now_ms());
        if (now_ms() - *lost_since_ms_ >= lost_ms) {
            say_why(fmt::format("the host at {} does not answer", way_.address));
            return gone;
        }
    }
    return std::nullopt;
}

void Joined::end_processes() {
    const std::int64_t deadline_ms = now_ms() + terminate_ms;
    supervisor_.kill_all(SIGTERM);
    while (!supervisor_.running().empty() && now_ms() < deadline_ms) {
        const std::int64_t left_ms = std::min<std::int64_t>(deadline_ms - now_ms(), beat_ms_);
        supervisor_.wait(-1, static_cast<int>(std::max<std::int64_t>(left_ms, 1)));
        send_ended();
        send_beat();
        supervisor_.take_interrupt();
    }
    supervisor_.kill_all(SIGKILL);  // The supervisor waits for them in its destructor.
}

int Joined::run() {
    if (watches_input_) {
        polled_.add(STDIN_FILENO);
    }
    while (take_letters()) {
        if (const std::optional<int> code = reason_to_end()) {
            end_processes();
            return *code;
        }
        send_ended();
        send_beat();
        if (!take_letters()) {
            break;
        }
        wait(beaten_ms_ + beat_ms_ - now_ms());
    }
    end_processes();
    if (dismissal_.empty()) {
        return 0;
    }
    say_why(dismissal_);
    return static_cast<int>(ExitCode::unavailable);
}

}  // namespace

int join_machine(const JoinOptions& options) {
    const bus::Credentials credentials = key_of(options);
    Supervisor supervisor;    // Hears signals between two machines, too.
    std::optional<int> code;  // Of the last machine.
    std::string said;
    std::int64_t end_ms = now_ms() + std::int64_t{1000} * options.wait_s;
    for (;;) {
        try {
            const Way way = await_way(options.addresses, end_ms, supervisor, say_why);
            Joined joined(way, credentials, options.key_from_input);
            joined.introduce(options);
            say_why(fmt::format("takes part in the machine at {}", way.address));
            code = joined.run();
            if (!options.again || *code > signal_code || joined.is_released() ||
                joined.input_is_closed()) {
                return *code;
            }
            end_ms = now_ms() + std::int64_t{1000} * options.wait_s;
        } catch (const RequestError& error) {  // No host.
            if (!code) {
                throw;
            }
            say_why(error.what());
            return *code;
        } catch (const BadLetter& error) {
            throw MachineError(
                ExitCode::unavailable,
                fmt::format(
                    "the host at {} is of another build: {}. Install the same pxpl5 on both",
                    options.addresses, error.what()));
        } catch (const MachineError& error) {  // The host refuses this computer, or has gone.
            if (!options.again || error.is_interruption || now_ms() >= end_ms) {
                throw;
            }
            if (error.what() != std::exchange(said, error.what())) {
                say_why(fmt::format("{}; it is asked again", said));
            }
        }
        supervisor.wait(-1, again_ms);
    }
}

}  // namespace pxpl5::host
