#include "host/machine/computers/plan_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "host/machine/computers/placement.hpp"
#include "isa/contract/triangle_shape.hpp"
#include "ringbus/rules/regions.hpp"

namespace pxpl5::host {

namespace {

using bus::schema::Role;

constexpr std::uint32_t usual_px = 512;
constexpr double bytes_per_mb = 1e6;

std::string missing_text(const ClusterSettings& cluster) {
    if (cluster.computers.empty()) {
        return "plan: unknown before the computers have joined; name them to see it, for example "
               "--computers n1:8,n2:8\n";
    }
    const auto unknown =
        std::ranges::find_if(cluster.computers, [](const auto& c) { return c.slots == 0; });
    return unknown == cluster.computers.end()
               ? std::string()
               : fmt::format(
                     "plan: the cores of {0} are unknown before it has joined; say how "
                     "many nodes it takes to see the plan, for example {0}:8\n",
                     unknown->name);
}

/// "gp-0..3, renderer-1"
std::string names_text(const std::map<Role, std::vector<int>>& nodes) {
    std::string text;
    for (const auto& [role, indices] : nodes) {
        for (std::size_t i = 0; i < indices.size();) {
            std::size_t end = i + 1;
            while (end < indices.size() && indices[end] == indices[end - 1] + 1) {
                ++end;
            }
            RosterEntry first;
            first.role = role;
            first.index = indices[i];
            text += text.empty() ? first.name() : ", " + first.name();
            text += end - i > 1 ? fmt::format("..{}", indices[end - 1]) : std::string();
            i = end;
        }
    }
    return text;
}

std::string computers_text(const Roster& roster, const std::vector<int>& places,
                           const std::vector<ComputerSlots>& computers) {
    std::string text;
    for (int place = 0; place <= static_cast<int>(computers.size()); ++place) {
        std::map<Role, std::vector<int>> nodes;
        std::size_t count = 0;
        for (std::size_t i = 0; i < roster.size(); ++i) {
            if (places[i] == place) {
                nodes[roster[i].role].push_back(roster[i].index);
                ++count;
            }
        }
        const bool is_own = place == own_computer;
        const ComputerSlots* slots =
            is_own ? nullptr : &computers[static_cast<std::size_t>(place) - 1];
        text += fmt::format("  {:<16} {:>2} node{}  {}{}\n", is_own ? "this computer" : slots->name,
                            count, count == 1 ? " " : "s", names_text(nodes),
                            !is_own && static_cast<int>(count) > slots->slots
                                ? fmt::format("  (more than its {} slots)", slots->slots)
                                : std::string());
    }
    return text;
}

}  // namespace

NetworkForecast network_forecast(const Roster& roster, const std::vector<int>& places,
                                 std::uint32_t width, std::uint32_t height, Recording recording) {
    int frame_buffer = own_computer;
    std::map<int, double> gps, renderers;  // Nodes by computer.
    double gp_count = 0, renderer_count = 0;
    for (std::size_t i = 0; i < roster.size(); ++i) {
        if (roster[i].role == Role::gp) {
            ++gps[places[i]];
            ++gp_count;
        } else if (roster[i].role == Role::renderer) {
            ++renderers[places[i]];
            ++renderer_count;
        } else if (roster[i].role == Role::frame_buffer && roster[i].index == 0) {
            frame_buffer = places[i];
        }
    }
    double near_pairs = 0;
    for (const auto& [computer, count] : gps) {
        near_pairs += count * renderers[computer];
    }
    const double far_renderers = renderer_count - renderers[frame_buffer];
    const std::uint64_t region_bytes = std::uint64_t{region_px} * region_px * sizeof(std::uint32_t);
    NetworkForecast forecast;
    forecast.pixel_bytes = static_cast<std::uint64_t>(
        static_cast<double>(region_count(width, height, 1) * region_bytes) * far_renderers /
        renderer_count);
    forecast.picture_bytes =
        frame_buffer == own_computer ? 0 : std::uint64_t{width} * height * sizeof(std::uint32_t);
    const std::size_t program_bytes =
        isa::triangle::word_count * sizeof(std::uint32_t) +
        (recording == Recording::off ? 0 : sizeof(bus::schema::Origin));
    forecast.bytes_per_triangle =
        static_cast<double>(program_bytes) * (1 - near_pairs / (gp_count * renderer_count));
    return forecast;
}

std::string plan_text(const Topology& topology) {
    const ClusterSettings& cluster = topology.cluster;
    if (!cluster.is_used()) {
        return {};
    }
    if (const std::string missing = missing_text(cluster); !missing.empty()) {
        return missing;
    }
    const Roster roster = roster_of(topology);
    const std::vector<int> places = place_nodes(roster, topology, cluster.computers);
    const NetworkForecast forecast =
        network_forecast(roster, places, usual_px, usual_px, topology.record);
    return fmt::format(
        "plan:\n{}expected between computers, for a frame of {} x {} pixels: {:.2f} MB of pixels,\n"
        "and {:.2f} MB for each 10000 triangles in sight, once for each region that they touch\n",
        computers_text(roster, places, cluster.computers), usual_px, usual_px,
        static_cast<double>(forecast.pixel_bytes + forecast.picture_bytes) / bytes_per_mb,
        forecast.bytes_per_triangle * 1e4 / bytes_per_mb);
}

}  // namespace pxpl5::host
