#include "host/machine/computers/processes.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string_view>
#include <utility>

#include "host/machine/computers/key.hpp"
#include "host/machine/port.hpp"

namespace pxpl5::host {

namespace {

/// A pipe with `text`, whose write end stays open.
std::array<int, 2> pipe_with(std::string_view text) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0 ||
        write(ends[1], text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
        throw MachineError(
            ExitCode::unavailable,
            fmt::format("cannot hand the key to other computers: {}", std::strerror(errno)));
    }
    return ends;
}

}  // namespace

Processes::Processes(const Topology& topology, const bus::Credentials& credentials,
                     Identity identity, std::filesystem::path folder)
    : topology_(topology), credentials_(credentials), folder_(std::move(folder)) {
    if (topology.cluster.is_used()) {
        others_.emplace(topology.cluster, credentials, std::move(identity), folder_);
    }
}

Processes::~Processes() {
    for (const int input : inputs_) {
        close(input);
    }
}

void Processes::start_engine(const std::filesystem::path& program) {
    const ClusterSettings& cluster = topology_.cluster;
    const KeyWay way = key_way_of(cluster.engine);
    JoinCommand join{program.string(), others_->addresses(), {}};
    if (way == KeyWay::munge) {
        join.key = munge_credential(credentials_);
    } else if (way == KeyWay::file) {
        if (cluster.key_file.empty()) {
            join.key = (folder_ / "join.key").string();
            write_key_file(join.key, credentials_);
        } else {
            join.key = std::filesystem::absolute(cluster.key_file).string();
        }
        join_line_ = host::join_line(join, way);
    }
    for (const EngineProcess& engine : engine_processes(cluster, join)) {
        ProcessCommand command;
        command.name = engine.name;
        command.program = engine.words.front();
        command.arguments.assign(engine.words.begin() + 1, engine.words.end());
        command.env = engine.env;
        command.log = folder_ / (engine.name + ".log");
        command.log_arguments = way != KeyWay::munge;  // The credential is for this user only.
        if (way == KeyWay::input) {
            const auto [read_end, write_end] = pipe_with(key_text(credentials_));
            inputs_.push_back(write_end);
            command.input = read_end;
        }
        const std::shared_ptr<void> closer(nullptr, [input = command.input](void*) {
            if (input >= 0) {
                close(input);
            }
        });
        own_.spawn(command);
    }
}

void Processes::note_lost(const std::string& dead) {
    lost_ = others_ ? others_->lost() : std::vector<std::string>{};
    for (const ComputerSlots& computer : topology_.cluster.computers) {
        if (dead == fmt::format("{}{}", engine_prefix, computer.name)) {
            lost_.push_back(computer.name);
        }
    }
}

bool Processes::only_engine_runs() const {
    const std::vector<std::string> names = running();
    return std::ranges::all_of(names, is_engine);
}

void Processes::finish() {
    if (others_ && !std::exchange(is_finished_, true)) {
        others_->finish();
    }
}

int Processes::spawn(int computer, const ProcessCommand& command, int pulse_ms) {
    if (computer == 0) {
        return own_.spawn(command);
    }
    others_->spawn(computer, command, pulse_ms);
    return 0;
}

std::vector<Death> Processes::take_deaths() {
    std::vector<Death> deaths = own_.take_deaths();
    if (others_) {
        const std::vector<Death> more = others_->take_deaths();
        // What happened on a computer explains the end of the engine, not the other way round.
        deaths.insert(deaths.begin(), more.begin(), more.end());
    }
    return deaths;
}

std::vector<std::string> Processes::running() const {
    std::vector<std::string> names = own_.running();
    if (others_) {
        const std::vector<std::string> more = others_->running();
        names.insert(names.end(), more.begin(), more.end());
    }
    return names;
}

void Processes::kill(const std::string& name, int signal) {
    if (others_ && others_->has(name)) {
        others_->kill(name, signal);
    } else {
        own_.kill(name, signal);
    }
}

void Processes::kill_all(int signal) {
    const bool spares_engine = signal != SIGKILL && !only_engine_runs();
    for (const std::string& name : own_.running()) {
        if (!spares_engine || !is_engine(name)) {  // Its end would end nodes in the middle.
            own_.kill(name, signal);
        }
    }
    if (others_) {
        others_->kill_all(signal);
    }
}

void Processes::pump(std::int64_t now_ms) {
    if (others_) {
        others_->pump(now_ms);
    }
}

int Processes::poll_fd(int link_fd) {
    if (!others_) {
        return link_fd;
    }
    if (!polled_) {
        polled_.emplace({link_fd, others_->poll_fd()});
    }
    return polled_->fd();
}

int Processes::wait_ms(int timeout_ms) const {
    if (!others_) {
        return timeout_ms;
    }
    return timeout_ms < 0 ? RemoteComputers::beat_ms
                          : std::min(timeout_ms, RemoteComputers::beat_ms);
}

}  // namespace pxpl5::host
