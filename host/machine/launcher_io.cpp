// Launcher: the io processes.
#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <system_error>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/kernel/memory_kills.hpp"
#include "host/base/kernel/protections.hpp"
#include "host/base/kernel/standard_streams.hpp"
#include "host/machine/launcher.hpp"

namespace pxpl5::host {

namespace {

constexpr int max_kept_logs = 100;  // Logs of failed io processes.

/// Warns once per machine that files of strangers are read with less protection than usual.
void print_missing_protections(bool has_sandbox) {
    if (!has_sandbox) {
        print_notice("warning",
                     "--no-io-sandbox: a crafted file can do what this user can do; "
                     "load trusted files only");
        return;
    }
    for (const std::string& missing :
         missing_protections(landlock_version(), has_system_call_filters())) {
        print_notice("note", fmt::format("this system has no {}", missing));
    }
}

}  // namespace

bool Launcher::has_io_id(bus::NodeId id) const {
    return (io_.used && io_.used->id == id) || (io_.prepared && io_.prepared->id == id) ||
           io_.dismissed.contains(id);
}

bool Launcher::has_io_index(int index) const {
    return (io_.used && io_.used->index == index) ||
           (io_.prepared && io_.prepared->index == index) ||
           std::ranges::any_of(io_.dismissed,
                               [index](const auto& past) { return past.second.index == index; });
}

RosterEntry Launcher::spawn_io() {
    if (io_.started == 0) {
        print_missing_protections(options_.io_sandbox);
    }
    bury_dismissed();
    RosterEntry node;
    node.role = bus::schema::Role::io;
    do {
        node.id = static_cast<bus::NodeId>(roster_.size() + io_.started++ % options_.io_ids);
    } while (has_io_id(node.id));
    while (has_io_index(node.index)) {
        ++node.index;
    }
    try {
        std::vector<std::string> arguments = {"--memory-mib",
                                              std::to_string(options_.io_memory_mib), "--cpu-s",
                                              std::to_string(options_.io_cpu_s)};
        for (const std::string& folder : options_.io_allow) {
            arguments.push_back("--allow=" + folder);
        }
        if (!options_.io_sandbox) {
            arguments.emplace_back("--no-sandbox");
        }
        spawn(node, {}, arguments);
    } catch (const MachineError& error) {
        throw RequestError(ExitCode::unavailable, error.what());
    }
    return node;
}

/// Whether an earlier io process sent the message, or a prepared one, whose Hello is kept. A
/// prepared process sends no other message on its own.
bool Launcher::is_not_for_now(const bus::Message& message) {
    if (io_.prepared && io_.prepared->id == message.source()) {
        note(message);
        if (message.kind() == bus::Body::Hello) {
            io_.early_hello = message;
        }
        return true;
    }
    return io_.dismissed.count(message.source()) != 0;
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
    io_.memory_kills = memory_kills();
    io_.used = bring_up({*io_.used}).front();
    return io_.used->id;
}

/// Ends a prepared process that has no request.
void Launcher::drop_prepared_io() {
    if (io_.prepared) {
        processes_.kill(io_.prepared->name(), SIGKILL);
        io_.dismissed.emplace(io_.prepared->id, *io_.prepared);
        heartbeat_.forget(io_.prepared->name());
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
    io_.dismissed.emplace(io_.used->id, *io_.used);
    heartbeat_.forget(io_.used->name());
    std::erase_if(backlog_.messages, [this](const bus::Message& message) {
        const bool is_its_own = message.source() == io_.used->id;
        backlog_.bytes -= is_its_own ? message.bytes().size() : 0;
        return is_its_own;
    });
    io_.used.reset();
}

void Launcher::kill_io() {
    if (io_.used) {
        processes_.kill(io_.used->name(), SIGKILL);
        io_.used->endpoint.clear();
        dismiss_io();
    }
}

void Launcher::bury_dismissed() {
    const std::vector<std::string> running = processes_.running();
    for (auto past = io_.dismissed.begin(); past != io_.dismissed.end();) {
        const std::string name = past->second.name();
        if (std::find(running.begin(), running.end(), name) != running.end()) {
            processes_.kill(name, SIGKILL);
            ++past;
        } else {
            link_.remove_peer(past->first);
            past = io_.dismissed.erase(past);
        }
    }
}

bool Launcher::was_dismissed(const Death& death) const {
    return std::any_of(io_.dismissed.begin(), io_.dismissed.end(),
                       [&death](const auto& past) { return past.second.name() == death.name; });
}

/// Keeps the log, which the next io process of this name would overwrite.
IoFailure Launcher::io_error(const Death& death) {
    const std::filesystem::path log = folder_ / (death.name + ".log");
    const std::filesystem::path kept =
        folder_ / fmt::format("{}.failed-{}.log", death.name, io_.started % max_kept_logs);
    const std::string said = last_words(log);
    std::error_code error;
    std::filesystem::rename(log, kept, error);
    const bus::PulseCell* const cell = heartbeat_.cell_of(death.name);
    IoDeath io;
    io.death = death;
    io.file = work_;
    if (cell != nullptr) {
        const bus::PulseReading pulse = cell->read();
        io.doing = io_work_text(pulse);
        io.has_request = !is_idle(pulse);
    }
    io.said = said;
    io.log = error ? log : kept;
    io.memory = memory_lack(io_.memory_kills, memory_kills());
    io.cpu_s = options_.io_cpu_s;
    io.otherwise = io_.death_code;
    return error_of(io);
}

}  // namespace pxpl5::host
