#include "host/machine/computers/processes.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <memory>
#include <string_view>
#include <utility>

#include "host/machine/computers/join/key.hpp"
#include "host/machine/port.hpp"

namespace pxpl5::host {

namespace {

/// A pipe with `text`, whose write end stays open.
std::array<int, 2> pipe_with(std::string_view text) {
    std::array<int, 2> ends = {-1, -1};
    if (pipe2(ends.data(), O_CLOEXEC) != 0 ||
        write(ends[1], text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
        const int reason = errno;
        for (const int end : ends) {
            if (end >= 0) {
                close(end);
            }
        }
        throw MachineError(
            ExitCode::unavailable,
            fmt::format("cannot hand the key to other computers: {}", std::strerror(reason)));
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
    for (const auto& [engine, input] : inputs_) {
        close(input);
    }
}

void Processes::begin(const std::filesystem::path& folder) {
    own_.wait(-1, 0);
    pump(now_ms());
    take_deaths();  // Of engines; the nodes have ended.
    for (const std::string& engine : others_->broken_engines()) {
        others_->take_end_of_engine(engine, "it is started again without a lost computer");
        end_engine(engine);
    }
    folder_ = folder;
    lost_ = others_->open(folder);
    for (const FormerComputer& computer : others_->former()) {
        if (!computer.is_released) {
            end_engine_of(computer.name);
        }
    }
}

void Processes::forget_link() {
    if (polled_ && polled_link_ >= 0) {
        polled_->remove(std::exchange(polled_link_, -1));
    }
    if (others_) {
        others_->on_pulse({});
    }
}

const std::string& Processes::join_line(const std::filesystem::path& program) {
    if (join_line_.empty()) {
        JoinCommand join{program.string(), others_->addresses(), {}};
        if (topology_.cluster.key_file.empty()) {
            join.key = (folder_ / "join.key").string();
            write_key_file(join.key, credentials_);
        } else {
            join.key = std::filesystem::absolute(topology_.cluster.key_file).string();
        }
        join_line_ = host::join_line(join, KeyWay::file);
    }
    return join_line_;
}

JoinCommand Processes::join_command(KeyWay way, const std::filesystem::path& program) const {
    JoinCommand join{program.string(), others_->addresses(), {}};
    if (way == KeyWay::munge) {
        join.key = munge_credential(credentials_);
    }
    return join;
}

void Processes::start_engine(const ClusterSettings& cluster, const std::filesystem::path& program) {
    const KeyWay way = key_way_of(cluster.engine);
    for (const EngineProcess& engine : engine_processes(cluster, join_command(way, program))) {
        spawn_engine(engine, way);
        if (engine.starts_all) {
            others_->expect_from(engine.name);
        }
    }
}

void Processes::start_engine_for(const std::string& computer,
                                 const std::filesystem::path& program) {
    ClusterSettings one = topology_.cluster;
    one.computers = {{computer, 0}};
    one.wait = 0;
    one.lost.clear();
    const KeyWay way = key_way_of(one.engine);
    for (EngineProcess engine : engine_processes(one, join_command(way, program))) {
        engine.name = engine_process(computer);
        spawn_engine(engine, way);
    }
}

std::optional<Death> Processes::ended_engine(const std::string& computer) const {
    const auto found = ended_engines_.find(engine_process(computer));
    return found == ended_engines_.end() ? std::nullopt : std::optional(found->second);
}

void Processes::close_input(const std::string& engine) {
    if (const auto found = inputs_.find(engine); found != inputs_.end()) {
        close(found->second);
        inputs_.erase(found);
    }
}

void Processes::end_engine_of(const std::string& computer) {
    end_engine(engine_process(computer));
}

void Processes::end_engine(const std::string& engine) {
    close_input(engine);
    if (drop_engine(engine)) {
        own_.end(engine, SIGKILL);
    }
}

bool Processes::drop_engine(const std::string& engine) {
    const bool runs = std::ranges::count(own_.running(), engine) > 0;
    if (runs) {
        dropped_engines_.insert(engine);
    }
    return runs;
}

bool Processes::release(const std::string& computer) {
    drop_engine(engine_process(computer));
    return others_->release(computer);
}

std::filesystem::path Processes::log_of(const std::string& name) const {
    const auto found = engine_logs_.find(name);
    return found == engine_logs_.end() ? folder_ / (name + ".log") : found->second;
}

void Processes::spawn_engine(const EngineProcess& engine, KeyWay way) {
    ProcessCommand command;
    command.name = engine.name;
    command.program = engine.words.front();
    command.arguments.assign(engine.words.begin() + 1, engine.words.end());
    command.env = engine.env;
    command.log = engine_logs_[engine.name] = folder_ / (engine.name + ".log");
    command.log_arguments = way != KeyWay::munge;  // The credential is for this user only.
    close_input(engine.name);
    ended_engines_.erase(engine.name);
    if (way == KeyWay::input) {
        const auto [read_end, write_end] = pipe_with(key_text(credentials_));
        inputs_[engine.name] = write_end;
        command.input = read_end;
    }
    const std::shared_ptr<void> closer(nullptr, [input = command.input](void*) {
        if (input >= 0) {
            close(input);
        }
    });
    own_.spawn(command);
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
    if (!others_) {
        return own_.take_deaths();
    }
    // What happened on a computer explains the end of the engine, not the other way round.
    std::vector<Death> deaths = others_->take_deaths();
    for (const Death& death : own_.take_deaths()) {
        if (!is_engine(death.name)) {
            deaths.push_back(death);
        } else if (dropped_engines_.erase(death.name) == 0) {
            const bool ends_nodes = others_->take_end_of_engine(death.name, death.text());
            if (ends_nodes || others_->is_open() || is_finished_) {
                deaths.push_back(death);
            } else {
                ended_engines_[death.name] = death;
            }
        }
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

std::vector<std::string> Processes::running_nodes() const {
    std::vector<std::string> names = running();
    std::erase_if(names, is_engine);
    return names;
}

void Processes::kill(const std::string& name, int signal) {
    if (others_ && others_->has(name)) {
        others_->kill(name, signal);
    } else {
        own_.kill(name, signal);
    }
}

void Processes::kill_all(int signal, bool spares_engine) {
    spares_engine |= signal != SIGKILL && !running_nodes().empty();
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
        polled_.emplace({others_->poll_fd()});
    }
    if (polled_link_ != link_fd) {
        polled_->add(link_fd);
        polled_link_ = link_fd;
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
