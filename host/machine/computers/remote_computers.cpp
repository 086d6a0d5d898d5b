#include "host/machine/computers/remote_computers.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <span>
#include <utility>

#include "host/base/kernel/standard_streams.hpp"
#include "host/machine/computers/cluster_settings.hpp"
#include "host/machine/computers/facts.hpp"
#include "host/machine/port.hpp"

namespace pxpl5::host {

namespace {

constexpr std::size_t max_warnings = 100;
constexpr std::size_t max_reason = 200, max_text = 1000;  // Characters.

/// The files of a process, in the run folder.
bool is_file_of(const std::string& file, const std::string& name) {
    return file == name + ".log" || file == "traces/" + name + ".mcap";
}

/// Appends to a file for this user alone. The first part replaces an earlier file. Returns why that
/// failed, or nothing.
std::string write_part(const std::filesystem::path& path, std::span<const std::uint8_t> bytes,
                       bool is_first) {
    const int file = open(
        path.c_str(), O_WRONLY | O_CREAT | O_NOFOLLOW | O_CLOEXEC | (is_first ? O_TRUNC : O_APPEND),
        S_IRUSR | S_IWUSR);
    ssize_t written = file < 0 ? -1 : 0;
    while (written >= 0 && !bytes.empty()) {
        written = write(file, bytes.data(), bytes.size());
        bytes = bytes.subspan(static_cast<std::size_t>(std::max<ssize_t>(written, 0)));
    }
    std::string reason = written < 0 ? std::strerror(errno) : "";
    if (file >= 0) {
        close(file);
    }
    return reason;
}

std::string lost_text(const std::string& name, const std::string& computer,
                      const std::string& reason) {
    return fmt::format("{} is lost with computer {}: {}", name, computer, reason);
}

}  // namespace

RemoteComputers::RemoteComputers(const ClusterSettings& cluster,
                                 const bus::Credentials& credentials, Identity identity,
                                 std::filesystem::path folder)
    : port_(cluster.listen.empty() ? "0.0.0.0" : cluster.listen, cluster.listen_port, credentials),
      listen_(cluster.listen),
      credentials_(credentials),
      identity_(std::move(identity)),
      folder_(std::move(folder)) {}

std::string RemoteComputers::addresses() const {
    std::vector<std::string> addresses = own_addresses();
    if (!listen_.empty() && listen_ != "0.0.0.0") {
        addresses = {listen_};
    }
    if (addresses.empty()) {
        addresses = {"127.0.0.1"};
    }
    for (std::string& address : addresses) {
        address = fmt::format("tcp://{}:{}", address, port_.port());
    }
    return fmt::format("{}", fmt::join(addresses, ","));
}

RemoteComputer* RemoteComputers::computer_of_line(const std::string& line) {
    const auto found =
        std::ranges::find_if(computers_, [&](const RemoteComputer& c) { return c.line == line; });
    return found == computers_.end() ? nullptr : &*found;
}

RemoteComputer* RemoteComputers::computer_of(const std::string& process) {
    const auto found = std::ranges::find_if(
        computers_, [&](const RemoteComputer& c) { return c.running.contains(process); });
    return found == computers_.end() ? nullptr : &*found;
}

void RemoteComputers::take(const std::string& line, const join::LetterT& letter) {
    const join::WordUnion& word = letter.word;
    if (const auto* ask = word.AsAsk()) {
        take_ask(line, *ask);
        return;
    }
    RemoteComputer* computer = computer_of_line(line);
    if (computer == nullptr && gone_.lines.contains(line)) {
        return;
    }
    if (computer == nullptr) {
        join::DismissT dismiss;  // Its exit code says that it did not end in order.
        dismiss.reason =
            "the host does not know this connection: it was interrupted, or the machine is "
            "another one";
        port_.send(line, packed_letter(std::move(dismiss)));
        ++refused_;
        return;
    }
    if (computer->is_lost) {  // Its last letters.
        return;
    }
    computer->silent_ms = 0;
    if (const auto* beat = word.AsBeat()) {
        take_beat(*computer, *beat);
    } else if (const auto* content = word.AsContent()) {
        take_content(*computer, *content);
    } else if (const auto* ended = word.AsEnded()) {
        take_ended(*computer, *ended);
    } else if (word.AsMeasured() != nullptr) {
        ++computer->measured;
    } else if (const auto* leave = word.AsLeave()) {
        computer->leaves = printable(leave->reason.substr(0, max_reason));
    } else {
        ++refused_;
    }
}

void RemoteComputers::pump(std::int64_t now_ms) {
    while (const auto received = port_.receive()) {
        try {
            take(received->from, unpacked_letter(received->letter));
        } catch (const BadLetter&) {
            ++refused_;
        }
    }
    if (port_.strangers() > 0) {
        warn(
            fmt::format("a program without the key of this machine has connected to port {}, "
                        "where computers join. The host sent it nothing",
                        port_.port()));
    }
    // While the host did not listen, letters could not be taken: that time is not silence.
    const std::int64_t passed_ms =
        looked_ms_ ? std::min<std::int64_t>(now_ms - *looked_ms_, beat_ms) : 0;
    looked_ms_ = now_ms;
    for (RemoteComputer& computer : computers_) {
        computer.silent_ms += passed_ms;
        if (!computer.is_lost && computer.silent_ms > lost_ms) {
            lose(computer, fmt::format("it has not answered for {:.1f} s",
                                       static_cast<double>(computer.silent_ms) / 1000));
        }
    }
    if (is_open_) {  // Others may join instead.
        std::erase_if(computers_,
                      [](const RemoteComputer& c) { return c.is_lost || !c.leaves.empty(); });
    }
}

std::string RemoteComputers::reason_to_refuse(const join::AskT& ask) const {
    // Takes as long for any secret.
    if (((ask.secret_low ^ credentials_.secret.low()) |
         (ask.secret_high ^ credentials_.secret.high())) != 0) {
        return "its key is not of this machine";
    }
    if (ask.build != identity_.build || ask.schema_hash != identity_.schema_hash) {
        return fmt::format(
            "it has build '{}' with messages of schema {:016x}, the host build '{}' "
            "with {:016x}. Install the same pxpl5 on both",
            ask.build, ask.schema_hash, identity_.build, identity_.schema_hash);
    }
    if (const std::string problem = problem_of_name(ask.facts->name); !problem.empty()) {
        return fmt::format("its name is '{}'; {}. Give it a name with --name",
                           printable(ask.facts->name.substr(0, max_reason)), problem);
    }
    const auto present = std::ranges::count_if(computers_, &RemoteComputer::takes_part);
    if (present >= max_computers) {
        return fmt::format("the machine has {} computers, at most {} may join", present,
                           max_computers);
    }
    return {};
}

void RemoteComputers::take_ask(const std::string& line, const join::AskT& ask) {
    join::AnswerT answer;
    answer.beat_ms = beat_ms;
    answer.refusal = reason_to_refuse(ask);
    if (!answer.refusal.empty()) {
        ++refused_;
        warn(fmt::format("computer {} at {} was refused: {}", ask.facts->name.substr(0, max_reason),
                         ask.facts->address.substr(0, max_reason),
                         answer.refusal.substr(0, max_text)));
    } else if (computer_of_line(line) == nullptr) {
        RemoteComputer computer;
        computer.line = line;
        computer.facts = *ask.facts;
        computer.facts.name = printable(ask.facts->name.substr(0, max_reason));
        computer.engine = engine_;
        const int cores = computer.facts.cores;
        const std::string& name = computer.facts.name;
        std::erase_if(gone_.computers,
                      [&](const FormerComputer& each) { return each.name == name; });
        if (!is_open_) {
            news_.push_back(
                fmt::format("{} with {} core{} has joined. 'computers use' runs nodes "
                            "there",
                            name, cores, cores == 1 ? "" : "s"));
        }
        computers_.push_back(std::move(computer));
    }
    port_.send(line, packed_letter(std::move(answer)));
}

void RemoteComputers::take_beat(const RemoteComputer& computer, const join::BeatT& beat) {
    for (const auto& pulse : beat.pulses) {
        if (take_pulse_ && computer.running.contains(pulse->name)) {
            take_pulse_(pulse->name, {pulse->beats, pulse->progress, pulse->worked, pulse->cpu_ns,
                                      pulse->work, pulse->piece});
        }
    }
}

void RemoteComputers::take_content(const RemoteComputer& computer, const join::ContentT& content) {
    const bool is_own = std::ranges::any_of(
        computer.running, [&](const std::string& name) { return is_file_of(content.file, name); });
    if (!is_own) {
        ++refused_;
        return;
    }
    has_new_parts_ = true;
    const std::filesystem::path path = folder_ / content.file;
    const bool is_first = begun_files_.insert(content.file).second;
    if (const std::string reason = write_part(path, content.bytes, is_first); !reason.empty()) {
        warn(fmt::format("{} of computer {} cannot be written: {}", path.string(),
                         computer.facts.name, reason));
    }
    if (!content.error.empty()) {
        warn(
            fmt::format("{} of computer {}: {}", content.file, computer.facts.name, content.error));
    }
    if (content.is_last) {
        begun_files_.erase(content.file);
        awaited_files_.erase(content.file);
    }
}

void RemoteComputers::take_ended(RemoteComputer& computer, const join::EndedT& ended) {
    if (computer.running.erase(ended.name) == 0) {
        ++refused_;
        return;
    }
    forget_files_of(ended.name);  // Its files have come before.
    if (computer.leaves.empty()) {
        deaths_.push_back({ended.name, ended.exit_code, ended.signal, ended.error});
    } else {
        deaths_.push_back({ended.name, static_cast<int>(ExitCode::unavailable), 0,
                           lost_text(ended.name, computer.facts.name, computer.leaves)});
    }
}

void RemoteComputers::forget_files_of(const std::string& name) {
    for (std::set<std::string>* const files : {&awaited_files_, &begun_files_}) {
        std::erase_if(*files, [&](const std::string& file) { return is_file_of(file, name); });
    }
}

void RemoteComputers::lose(RemoteComputer& computer, const std::string& silence) {
    computer.is_lost = true;
    if (computer.leaves.empty()) {  // Else it has said why.
        computer.leaves = silence;
    }
    const std::string& reason = computer.leaves;
    if (is_open_) {
        warn(fmt::format("computer {} has left: {}", computer.facts.name, reason));
    } else if (computer.running.empty()) {
        news_.push_back(fmt::format("{} has left: {}", computer.facts.name, reason));
    }
    for (const std::string& name : std::exchange(computer.running, {})) {
        deaths_.push_back({name, static_cast<int>(ExitCode::unavailable), 0,
                           lost_text(name, computer.facts.name, reason)});
        forget_files_of(name);
    }
    dismiss(computer);  // If it only was slow.
}

void RemoteComputers::warn(const std::string& text) {
    if (warned_.size() < max_warnings && warned_.insert(text).second) {
        warnings_.push_back(printable(text));
    }
}

std::vector<std::string> RemoteComputers::take_warnings() {
    return std::exchange(warnings_, {});
}

void RemoteComputers::spawn(int number, const ProcessCommand& command, int pulse_ms) {
    RemoteComputer& computer = computers_.at(static_cast<std::size_t>(number) - 1);
    join::StartT start;
    start.name = command.name;
    start.program = command.program.filename().string();
    start.arguments = command.arguments;
    start.env = command.env;
    start.core = command.core;
    start.pulse_ms = static_cast<std::uint32_t>(pulse_ms);
    if (computer.is_lost) {
        deaths_.push_back({command.name, static_cast<int>(ExitCode::unavailable), 0,
                           lost_text(command.name, computer.facts.name, computer.leaves)});
        return;
    }
    computer.running.insert(command.name);
    port_.send(computer.line, packed_letter(std::move(start)));
}

void RemoteComputers::ask_bytes(int number, std::uint32_t bytes) {
    join::MeasureT letter;
    letter.bytes = bytes;
    port_.send(computers_.at(static_cast<std::size_t>(number) - 1).line, packed_letter(letter));
}

void RemoteComputers::kill(const std::string& name, int signal) {
    if (const RemoteComputer* computer = computer_of(name)) {
        join::SignalT letter;
        letter.name = name;
        letter.number = static_cast<std::uint16_t>(signal);
        port_.send(computer->line, packed_letter(std::move(letter)));
    }
}

void RemoteComputers::kill_all(int signal) {
    for (const std::string& name : running()) {
        kill(name, signal);
    }
}

bool RemoteComputers::has(const std::string& name) const {
    return std::ranges::any_of(computers_,
                               [&](const RemoteComputer& c) { return c.running.contains(name); });
}

std::vector<std::string> RemoteComputers::running() const {
    std::vector<std::string> names;
    for (const RemoteComputer& computer : computers_) {
        names.insert(names.end(), computer.running.begin(), computer.running.end());
    }
    return names;
}

std::vector<Death> RemoteComputers::take_deaths() {
    return std::exchange(deaths_, {});
}

void RemoteComputers::fetch(const std::string& name, const std::string& file) {
    if (const RemoteComputer* computer = computer_of(name)) {
        awaited_files_.insert(file);
        join::FetchT letter;
        letter.file = file;
        port_.send(computer->line, packed_letter(std::move(letter)));
    }
}

bool RemoteComputers::takes_parts() {
    return std::exchange(has_new_parts_, false) && !begun_files_.empty();
}

void RemoteComputers::finish() {
    for (const RemoteComputer& computer : computers_) {
        if (!computer.is_lost) {
            port_.send(computer.line, packed_letter(join::DismissT{}));
        }
    }
}

}  // namespace pxpl5::host
