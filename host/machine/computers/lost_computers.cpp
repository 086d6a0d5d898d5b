#include "host/machine/computers/lost_computers.hpp"

#include <algorithm>

#include "host/machine/computers/engine.hpp"

namespace pxpl5::host {

std::vector<std::string> leave_out(Topology& plan, const std::vector<std::string>& lost) {
    ClusterSettings& cluster = plan.cluster;
    const auto is_named = [&cluster](const std::string& name) {
        return std::ranges::any_of(cluster.computers,
                                   [&](const ComputerSlots& each) { return each.name == name; });
    };
    std::vector<std::string> left_out;
    for (const std::string& name : lost) {
        const bool is_known =
            std::ranges::count(left_out, name) + std::ranges::count(cluster.lost, name) > 0;
        if (!is_known && (cluster.computers.empty() || is_named(name))) {
            left_out.push_back(name);
        }
    }
    const int left = expected_computers(cluster) - static_cast<int>(left_out.size());
    if (left_out.empty() || left < 1) {
        return {};
    }
    const auto is_left_out = [&left_out](const std::string& name) {
        return std::ranges::count(left_out, name) > 0;
    };
    std::erase_if(cluster.computers,
                  [&](const ComputerSlots& each) { return is_left_out(each.name); });
    // Without names, the number of computers says how many may join.
    cluster.wait = cluster.wait > 0 || cluster.computers.empty() ? left : 0;
    cluster.lost.insert(cluster.lost.end(), left_out.begin(), left_out.end());
    for (RoleSettings* role : {&plan.gp, &plan.renderer, &plan.frame_buffer}) {
        std::erase_if(role->computer, is_left_out);
    }
    return left_out;
}

}  // namespace pxpl5::host
