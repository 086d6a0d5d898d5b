// RemoteComputers: computers that come and go while the session continues.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "host/machine/computers/engine.hpp"
#include "host/machine/computers/remote_computers.hpp"

namespace pxpl5::host {

RemoteComputer* RemoteComputers::present(const std::string& name) {
    const auto found = std::ranges::find_if(computers_, [&](const RemoteComputer& c) {
        return c.facts.name == name && c.takes_part();
    });
    return found == computers_.end() ? nullptr : &*found;
}

bool RemoteComputers::takes_part(const std::string& name) const {
    return std::ranges::any_of(computers_, [&](const RemoteComputer& c) {
        return c.facts.name == name && c.takes_part();
    });
}

void RemoteComputers::dismiss(const RemoteComputer& computer) {
    join::DismissT letter;
    letter.is_released = computer.is_released;
    if (!computer.is_released && !computer.ends_with_engine && !computer.leaves.empty()) {
        letter.reason = fmt::format("the host counts this computer as lost: {}", computer.leaves);
    }
    port_.send(computer.line, packed_letter(std::move(letter)));
    gone_.lines.insert(computer.line);
}

void RemoteComputers::bury(const RemoteComputer& computer) {
    const std::string& name = computer.facts.name;
    std::erase_if(gone_.computers, [&](const FormerComputer& each) { return each.name == name; });
    if (!takes_part(name)) {
        gone_.computers.push_back(
            {name, computer.facts.cores, computer.is_released, computer.leaves});
    }
}

std::vector<std::string> RemoteComputers::open(std::filesystem::path folder) {
    folder_ = std::move(folder);
    is_open_ = true;
    needs_engine_ = false;
    deaths_.clear();
    awaited_files_.clear();
    begun_files_.clear();
    for (RemoteComputer& computer : computers_) {
        if (!computer.running.empty() && computer.leaves.empty()) {
            computer.leaves = "its nodes do not end";
        }
        if (!computer.takes_part() && !computer.is_lost) {
            dismiss(computer);
        }
    }
    std::deque<RemoteComputer> gone;
    std::ranges::copy_if(computers_, std::back_inserter(gone),
                         [](const RemoteComputer& c) { return !c.takes_part(); });
    std::erase_if(computers_, [](const RemoteComputer& c) { return !c.takes_part(); });
    std::vector<std::string> lost;
    for (const RemoteComputer& computer : gone) {
        if (computer.ends_with_engine) {
            needs_engine_ = true;  // It may start the computer again.
            continue;
        }
        bury(computer);
        if (!computer.is_released && !takes_part(computer.facts.name)) {
            lost.push_back(computer.facts.name);
        }
    }
    return lost;
}

void RemoteComputers::close(const std::vector<std::string>& names) {
    is_open_ = false;
    engine_.clear();
    const auto place = [&](const RemoteComputer& computer) {
        return std::pair(std::ranges::find(names, computer.facts.name) - names.begin(),
                         computer.facts.name);
    };
    std::ranges::stable_sort(computers_, {}, place);
}

std::set<std::string> RemoteComputers::broken_engines() const {
    std::set<std::string> engines;
    for (const RemoteComputer& each : computers_) {
        if (!each.engine.empty() && !each.takes_part() && !each.is_released &&
            !each.ends_with_engine) {
            engines.insert(each.engine);
        }
    }
    return engines;
}

bool RemoteComputers::take_end_of_engine(const std::string& engine, const std::string& why) {
    bool has_processes = false;
    for (RemoteComputer& computer : computers_) {
        const bool is_own = engine == engine_process(computer.facts.name);
        if (computer.is_lost || computer.is_released || !(is_own || computer.engine == engine)) {
            continue;
        }
        has_processes |= !computer.running.empty();
        if (computer.leaves.empty()) {
            computer.leaves = why;
            computer.ends_with_engine = !is_own;
        }
    }
    return has_processes;
}

bool RemoteComputers::release(const std::string& name) {
    RemoteComputer* const computer = present(name);
    if (computer == nullptr) {
        return false;
    }
    computer->is_released = true;
    if (computer->running.empty()) {
        dismiss(*computer);
        computer->is_lost = true;
    }
    return true;
}

}  // namespace pxpl5::host
