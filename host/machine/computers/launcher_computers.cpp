// Launcher: where nodes run, and how they are reached.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <iterator>

#include "host/base/kernel/standard_streams.hpp"
#include "host/base/stopwatch.hpp"
#include "host/machine/computers/facts.hpp"
#include "host/machine/computers/network_rate.hpp"
#include "host/machine/computers/placement.hpp"
#include "host/machine/launcher.hpp"

namespace pxpl5::host {

namespace {

using bus::schema::Role;

constexpr int patient_s = 3600;  // For jobs in a queue, and for computers that a user starts.
constexpr int restart_s = 300;   // For the same after the death of a node.
constexpr int note_after_ms = 3000;

constexpr int measured_computers = 4, measure_limit_ms = 2000;

std::string port_of(const std::string& endpoint) {
    return endpoint.substr(endpoint.rfind(':') + 1);
}

/// Seconds that the host waits for computers.
int limit_s(Engine engine, const MachineOptions& options) {
    if (engine != Engine::slurm && engine != Engine::wait) {
        return options.start_timeout_s;
    }
    return options.is_restart ? restart_s : patient_s;
}

}  // namespace

std::string bind_address(Transport transport, const SocketFolder& sockets,
                         const std::string& name) {
    return transport == Transport::tcp ? "tcp://127.0.0.1:*" : near_address(sockets.path(), name);
}

std::string host_address(const Topology& topology, const SocketFolder& sockets) {
    const ClusterSettings& cluster = topology.cluster;
    return !cluster.is_used()
               ? bind_address(topology.ring.transport, sockets, "host")
               : fmt::format("tcp://{}:*", cluster.listen.empty() ? "0.0.0.0" : cluster.listen);
}

bus::ProcessFlags Launcher::flags_of(const RosterEntry& node) const {
    const std::string name = node.name();
    bus::ProcessFlags flags;
    flags.host_endpoint = node.role == Role::io ? io_.host_endpoint : link_.endpoint();
    // A late connection to an earlier io process must not reach a later one of the same name.
    flags.bind = bind_address(topology_.ring.transport, sockets_,
                              node.role == Role::io ? fmt::format("io-node-{}", node.id) : name);
    flags.node_id = node.id;
    flags.index = static_cast<std::uint16_t>(node.index);
    flags.parent_pid = getpid();
    flags.credentials_fd = first_inherited_fd;
    if (recorder_ && node.role != Role::io) {
        flags.record = static_cast<Recording>(topology_.record);
        flags.trace_file = trace_path(name).string();
        flags.flight_kib = flight_share_kib();
    }
    if (processes_.has_others() && node.role != Role::io) {
        add_computer_flags(node, flags);
    }
    return flags;
}

std::vector<MachineNode> Launcher::nodes() const {
    std::vector<MachineNode> nodes = nodes_of(roster_);
    if (processes_.has_others()) {
        const std::deque<RemoteComputer>& computers = processes_.others().computers();
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            const int computer = roster_[i].computer;
            nodes[i].place = roster_[i].place;
            nodes[i].computer = computer == own_computer
                                    ? own_facts().name
                                    : computers[static_cast<std::size_t>(computer) - 1].facts.name;
        }
    }
    return nodes;
}

void Launcher::print_news_of_computers() {
    for (const std::string& text : processes_.others().take_warnings()) {
        print_notice("warning", text);
    }
    for (const std::string& text : processes_.others().take_news()) {
        print_notice("note", text);
        if (watcher_.tell_computer) {
            watcher_.tell_computer(text);
        }
    }
}

void Launcher::wait_for_event(int most_ms) {
    processes_.own().wait(processes_.poll_fd(link_.poll_fd()), processes_.wait_ms(most_ms));
    processes_.pump(now_ms());
}

std::string Launcher::missing_computers() const {
    std::vector<std::string> names;
    for (const ComputerSlots& named : topology_.cluster.computers) {
        const auto& joined = processes_.others().computers();
        if (std::ranges::none_of(joined,
                                 [&](const auto& c) { return c.facts.name == named.name; })) {
            names.push_back(named.name);
        }
    }
    return names.empty() ? std::string()
                         : fmt::format("; missing: {}. Their logs are {}/engine-*.log",
                                       fmt::join(names, ", "), folder_.string());
}

void Launcher::await_computers() {
    leave_out_former();
    if (needs_engine()) {
        call_computers();
    }
    std::vector<std::string> names;
    std::ranges::transform(topology_.cluster.computers, std::back_inserter(names),
                           &ComputerSlots::name);
    processes_.others().close(names);
    print_news_of_computers();
}

void Launcher::call_computers() {
    RemoteComputers& others = processes_.others();
    const std::size_t expected =
        others.computers().size() + static_cast<std::size_t>(expected_computers(topology_.cluster));
    const bool is_silent = topology_.cluster.engine != Engine::wait;
    processes_.start_engine(topology_.cluster, options_.binaries / "pxpl5");
    if (!is_silent) {
        fmt::print(stderr,
                   "waiting for {} computer{}; run there, with a copy of the key file: {}\n",
                   expected, expected == 1 ? "" : "s", join_line());
    }
    const int patience_s = limit_s(topology_.cluster.engine, options_);
    const std::int64_t begin_ms = now_ms(), end_ms = begin_ms + std::int64_t{1000} * patience_s;
    std::int64_t noted_ms = begin_ms;
    std::string noted = is_silent ? "" : "0";
    while (others.computers().size() < expected) {
        check_health();
        const std::string joined = std::to_string(others.computers().size());
        const std::string state = fmt::format("{} of {} computers have joined", joined, expected);
        if (now_ms() >= end_ms) {
            fail(timeout_code,
                 fmt::format("{} within {} s{}", state, patience_s, missing_computers()));
        }
        if (joined != noted && now_ms() - noted_ms > note_after_ms) {
            noted = joined;
            noted_ms = now_ms();
            print_notice("waiting", state);
        }
        wait_for_event(static_cast<int>(end_ms - now_ms()));
        discard_messages(false);  // Else the link's descriptor stays readable.
    }
}

void Launcher::require_computer(const RemoteComputer& computer) const {
    if (computer.is_lost || !computer.leaves.empty()) {
        throw MachineError(ExitCode::unavailable,
                           fmt::format("computer {} is lost before the machine has started: {}",
                                       computer.facts.name, computer.leaves));
    }
}

std::optional<double> Launcher::measured_mb_s(int number) {
    RemoteComputers& others = processes_.others();
    const RemoteComputer& computer = others.computers()[static_cast<std::size_t>(number) - 1];
    std::optional<std::uint32_t> asked;
    std::int64_t end_ms = 0;  // Of all answers of one size.
    return host::measured_mb_s([&](std::uint32_t bytes) -> std::optional<std::int64_t> {
        if (asked != bytes) {
            asked = bytes;
            end_ms = now_ms() + measure_limit_ms;
        }
        const int before = computer.measured;
        const std::int64_t begin_ns = now_ns();
        others.ask_bytes(number, bytes);
        while (computer.measured == before) {
            check_health();
            require_computer(computer);
            if (now_ms() >= end_ms) {
                return std::nullopt;
            }
            wait_for_event(static_cast<int>(end_ms - now_ms()));
            discard_messages(false);
        }
        return now_ns() - begin_ns;
    });
}

void Launcher::measure_network() {
    const std::deque<RemoteComputer>& computers = processes_.others().computers();
    const int below = topology_.cluster.compress_below_mb_s;
    int left = measured_computers;
    for (std::size_t i = 0; i < computers.size() && left > 0 && below > 0; ++i) {
        if (computers[i].facts.place == own_facts().place) {
            continue;
        }
        --left;
        const double mb_s = measured_mb_s(static_cast<int>(i) + 1).value_or(0);
        if (mb_s < below) {
            link_.compress_far(true);
            print_notice(
                "note",
                fmt::format("the network to {} carries {:.0f} MB/s: messages between computers "
                            "are compressed",
                            computers[i].facts.name, mb_s));
            break;
        }
    }
}

void Launcher::gather_computers() {
    try {
        await_computers();
        measure_network();
        place();
    } catch (const MachineError& error) {
        if (over_) {
            throw;
        }
        fail(error.code, error.what());
    } catch (const RequestError& error) {
        fail(static_cast<int>(error.code), error.what());
    }
}

void Launcher::place() {
    const std::deque<RemoteComputer>& computers = processes_.others().computers();
    std::vector<ComputerSlots> slots;
    std::vector<std::string> places = {own_facts().place};
    for (const RemoteComputer& computer : computers) {
        require_computer(computer);
        ComputerSlots slot{computer.facts.name, 0};
        for (const ComputerSlots& named : topology_.cluster.computers) {
            slot.slots = named.name == slot.name ? named.slots : slot.slots;
        }
        slot.slots = slot.slots > 0 ? slot.slots : std::max<int>(computer.facts.cores, 1);
        slots.push_back(slot);
        places.push_back(computer.facts.place);
    }
    for (const ComputerSlots& named : topology_.cluster.computers) {
        const bool has_joined = std::ranges::any_of(
            slots, [&](const ComputerSlots& slot) { return slot.name == named.name; });
        if (!has_joined) {
            print_notice(
                "warning",
                fmt::format("no computer has joined as {}; its slots are not used", named.name));
        }
    }
    const std::vector<int> nodes = place_nodes(roster_, topology_, slots);
    for (std::size_t i = 0; i < roster_.size(); ++i) {
        roster_[i].computer = nodes[i];
        const auto own = std::ranges::find(places, places[static_cast<std::size_t>(nodes[i])]);
        roster_[i].place = static_cast<int>(own - places.begin());
    }
}

void Launcher::add_computer_flags(const RosterEntry& node, bus::ProcessFlags& flags) const {
    const std::deque<RemoteComputer>& computers = processes_.others().computers();
    const std::string name = node.name();
    const join::FactsT* const facts =
        node.computer == 0 ? nullptr
                           : &computers[static_cast<std::size_t>(node.computer) - 1].facts;
    flags.host_endpoint = node.place == 0 ? roster_[0].near_endpoint
                                          : fmt::format("tcp://{}:{}", facts->host_address,
                                                        port_of(link_.endpoint()));
    // Nodes of the host's computer are reached as another computer has reached the host.
    const auto far = std::ranges::find_if(computers, [](const RemoteComputer& computer) {
        return computer.facts.place != own_facts().place;
    });
    const std::string host_side =
        (far == computers.end() ? computers.front() : *far).facts.host_address;
    flags.bind = fmt::format("tcp://{}:*", node.place == 0 ? host_side : facts->address);
    flags.compress = link_.compresses_far();
    flags.near_bind =
        near_address(facts == nullptr ? sockets_.path().string() : facts->sockets, name);
    if (facts != nullptr) {
        flags.parent_pid = static_cast<int>(facts->pid);
        if (!flags.trace_file.empty()) {
            flags.trace_file = fmt::format("{}/traces/{}.mcap", facts->folder, name);
        }
    }
}

void Launcher::fetch_trace(bus::NodeId id) {
    const std::string name = name_of(id);
    if (processes_.has_others() && processes_.others().has(name)) {
        processes_.others().fetch(name, fmt::format("traces/{}.mcap", name));
    }
}

void Launcher::await_fetched(SavedTraces& saved, std::int64_t deadline_ms) {
    if (!processes_.has_others()) {
        return;
    }
    const RemoteComputers& others = processes_.others();
    while (!others.awaited_files().empty() && now_ms() < deadline_ms && !over_) {
        check_health();
        wait_for_event(wait_ms(std::max<std::int64_t>(deadline_ms - now_ms(), 0)));
        while (const std::optional<bus::Message> message = take_from_link()) {
            keep(*message);
        }
    }
    for (const std::string& file : others.awaited_files()) {
        saved.missing.push_back(file + ": has not come from the other computer");
    }
}

}  // namespace pxpl5::host
