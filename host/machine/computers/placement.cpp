#include "host/machine/computers/placement.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>
#include <string_view>

#include "host/base/error.hpp"

namespace pxpl5::host {

namespace {

using bus::schema::Role;

std::vector<std::string_view> names_of(const std::vector<ComputerSlots>& computers) {
    std::vector<std::string_view> names;
    for (const ComputerSlots& computer : computers) {
        names.push_back(computer.name);
    }
    return names;
}

/// The computers and the nodes that each has so far.
class Filling {
  public:
    Filling(const std::vector<ComputerSlots>& computers, std::size_t count)
        : computers_(computers), order_(computers.size()), used_(computers.size(), 0) {
        std::iota(order_.begin(), order_.end(), std::size_t{0});
        order_.resize(std::min(count, order_.size()));
    }

    void add(std::size_t computer) { ++used_[computer]; }
    /// The first computer with a free slot, else the one with the fewest nodes for its slots.
    std::size_t next_in_order() const {
        const auto free = std::ranges::find_if(
            order_, [this](std::size_t i) { return used_[i] < computers_[i].slots; });
        return free != order_.end() ? *free : least_used();
    }
    std::size_t least_used() const {
        return *std::ranges::min_element(order_, [this](std::size_t a, std::size_t b) {
            // After one more node: used / slots, without a division.
            return (used_[a] + 1) * computers_[b].slots < (used_[b] + 1) * computers_[a].slots;
        });
    }

  private:
    const std::vector<ComputerSlots>& computers_;
    std::vector<std::size_t> order_;
    std::vector<int> used_;
};

/// The fewest computers, in order, whose slots are enough for `nodes`; all if none are.
std::size_t fewest_for(const std::vector<ComputerSlots>& computers, int nodes) {
    int slots = 0;
    std::size_t count = 0;
    while (count < computers.size() && slots < nodes) {
        slots += computers[count++].slots;
    }
    return std::max<std::size_t>(count, 1);
}

std::size_t named(const std::string& name, const RosterEntry& node,
                  const std::vector<ComputerSlots>& computers) {
    const auto found =
        std::ranges::find_if(computers, [&](const ComputerSlots& c) { return c.name == name; });
    if (found == computers.end()) {
        throw RequestError(ExitCode::usage,
                           fmt::format("{} shall run on computer '{}', but only {} {} there",
                                       node.name(), name, fmt::join(names_of(computers), ", "),
                                       computers.size() == 1 ? "is" : "are"));
    }
    return static_cast<std::size_t>(found - computers.begin());
}

}  // namespace

std::vector<int> place_nodes(const Roster& roster, const Topology& topology,
                             const std::vector<ComputerSlots>& computers) {
    std::vector<int> places(roster.size(), own_computer);
    const int nodes = topology.gp.count + topology.renderer.count;
    const bool packs = topology.cluster.placement == Placement::pack;
    Filling filling(computers, packs ? fewest_for(computers, nodes) : computers.size());
    const auto put = [&](std::size_t node, std::size_t computer) {
        places[node] = static_cast<int>(computer) + 1;
        filling.add(computer);
    };
    const auto each_of = [&roster](Role role, const auto& act) {
        for (std::size_t i = 0; i < roster.size(); ++i) {
            if (roster[i].role == role) {
                act(i);
            }
        }
    };
    std::vector<bool> is_placed(roster.size(), false);
    for (const Role role : {Role::renderer, Role::gp, Role::frame_buffer}) {
        const std::vector<std::string>& pinned = settings_of(topology, role).computer;
        each_of(role, [&](std::size_t i) {
            if (!pinned.empty()) {
                const auto index = static_cast<std::size_t>(roster[i].index);
                put(i, named(pinned[index % pinned.size()], roster[i], computers));
                is_placed[i] = true;
            }
        });
    }
    for (const Role role : {Role::renderer, Role::gp}) {
        each_of(role, [&](std::size_t i) {
            if (!is_placed[i]) {
                put(i, packs ? filling.next_in_order() : filling.least_used());
            }
        });
    }
    return places;
}

}  // namespace pxpl5::host
