// Launcher: computers that come, go and stay from one machine of a session to the next.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "host/base/kernel/standard_streams.hpp"
#include "host/machine/computers/lost_computers.hpp"
#include "host/machine/launcher.hpp"

namespace pxpl5::host {

namespace {

constexpr int drain_ms = 500;  // For the engine to end by itself.

bool has(const std::vector<std::string>& names, const std::string& name) {
    return std::ranges::find(names, name) != names.end();
}

ComputerUse use_of(const RemoteComputer& computer, int nodes) {
    return computer.is_released && computer.is_lost       ? ComputerUse::released
           : computer.is_lost || !computer.leaves.empty() ? ComputerUse::lost
           : nodes > 0                                    ? ComputerUse::used
                                                          : ComputerUse::idle;
}

}  // namespace

std::shared_ptr<Processes> Launcher::keep_computers() {
    if (!processes_.has_others() || processes_.is_finished()) {
        return nullptr;
    }
    processes_.forget_link();
    return std::move(owned_);
}

void Launcher::end_computers() {
    if (!owned_ || !processes_.has_others() || processes_.is_finished()) {
        return;
    }
    if (!over_) {  // The nodes may work, but no answer is awaited.
        processes_.finish();
        return;
    }
    try {
        end_processes(drain_ms, Ending::all);
    } catch (const std::exception& error) {
        print_notice("warning",
                     fmt::format("other computers may not have ended: {}", error.what()));
    }
}

bool Launcher::needs_engine() const {
    return processes_.others().computers().empty() || processes_.others().needs_engine();
}

void Launcher::leave_out_former() {
    const RemoteComputers& others = processes_.others();
    std::vector<std::string> left_out = processes_.lost();
    if (needs_engine()) {
        std::vector<std::string> former;
        for (const FormerComputer& each : others.former()) {
            former.push_back(each.name);
        }
        left_out = leave_out(topology_, former);
    } else {
        const auto is_here = [&others](const auto& name) { return others.takes_part(name); };
        std::erase_if(topology_.cluster.computers,
                      [&](const ComputerSlots& each) { return !is_here(each.name); });
        for (RoleSettings* role : {&topology_.gp, &topology_.renderer, &topology_.frame_buffer}) {
            std::erase_if(role->computer, [&](const auto& name) { return !is_here(name); });
        }
    }
    for (const std::string& name : left_out) {
        if (has(processes_.lost(), name)) {
            print_notice("warning", fmt::format("the machine goes on without computer {}", name));
        }
    }
}

std::vector<MachineComputer> Launcher::computers() const {
    std::vector<MachineComputer> list;
    if (!processes_.has_others()) {
        return list;
    }
    const RemoteComputers& others = processes_.others();
    int number = 0;
    for (const RemoteComputer& computer : others.computers()) {
        ++number;
        const auto nodes = std::ranges::count(roster_, number, &RosterEntry::computer);
        const std::string& name = computer.facts.name;
        if (computer.takes_part() || !others.takes_part(name)) {
            list.push_back({name, use_of(computer, static_cast<int>(nodes)), computer.facts.cores,
                            static_cast<int>(nodes), computer.leaves});
        }
    }
    for (const FormerComputer& each : others.former()) {
        if (std::ranges::count(list, each.name, &MachineComputer::name) == 0) {
            list.push_back({each.name, each.is_released ? ComputerUse::released : ComputerUse::lost,
                            each.cores, 0, each.why});
        }
    }
    return list;
}

std::string Launcher::join_line() {
    if (!processes_.has_others()) {
        throw RequestError(ExitCode::usage, "this machine has no other computers");
    }
    return processes_.join_line(options_.binaries / "pxpl5");
}

void Launcher::await_computer(const std::string& name) {
    const std::string line = topology_.cluster.engine == Engine::wait ? join_line() : "";
    const RemoteComputers& others = processes_.others();
    if (others.takes_part(name)) {
        return;
    }
    if (!line.empty()) {
        throw RequestError(ExitCode::unavailable,
                           fmt::format("computer {} has not joined. Run there, with a copy of the "
                                       "key file: {} --name {}",
                                       name, line, name));
    }
    processes_.end_engine_of(name);
    processes_.start_engine_for(name, options_.binaries / "pxpl5");
    const std::int64_t end_ms = now_ms() + std::int64_t{1000} * options_.start_timeout_s;
    while (!others.takes_part(name)) {
        check_health();
        if (const std::optional<Death> death = processes_.ended_engine(name)) {
            throw RequestError(ExitCode::unavailable, fmt::format("computer {} has not joined: {}",
                                                                  name, describe(*death)));
        }
        if (now_ms() >= end_ms) {
            processes_.end_engine_of(name);
            throw RequestError(ExitCode::unavailable,
                               fmt::format("computer {} has not joined within {} s (log: {})", name,
                                           options_.start_timeout_s,
                                           processes_.log_of(engine_process(name)).string()));
        }
        wait_for_event(static_cast<int>(end_ms - now_ms()));
        while (const std::optional<bus::Message> message = take_from_link()) {
            keep(*message);
        }
    }
}

bool Launcher::release_computer(const std::string& name) {
    std::vector<std::string> known, present;
    for (const MachineComputer& each : computers()) {
        known.push_back(each.name);
        if (each.use == ComputerUse::used || each.use == ComputerUse::idle) {
            present.push_back(each.name);
        } else if (each.name == name && each.use == ComputerUse::released) {
            return false;
        }
    }
    if (!has(present, name)) {
        throw RequestError(ExitCode::usage,
                           known.empty()
                               ? "this machine has no other computers"
                               : fmt::format("computer '{}' takes no part; the computers are {}",
                                             name, fmt::join(known, ", ")));
    }
    if (present.size() == 1) {
        throw RequestError(ExitCode::usage,
                           fmt::format("computer {} is the only one that has joined, so its nodes "
                                       "have no other place. Let another one join first",
                                       name));
    }
    const auto& others = processes_.others().computers();
    const bool has_nodes = std::ranges::any_of(others, [&](const RemoteComputer& each) {
        return each.facts.name == name && each.takes_part() && !each.running.empty();
    });
    processes_.release(name);
    return has_nodes;
}

}  // namespace pxpl5::host
