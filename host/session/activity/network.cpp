#include "host/session/activity/network.hpp"

#include <algorithm>
#include <functional>
#include <map>

namespace pxpl5::host {

namespace {

ComputerReport& computer_of(const MachineNode& node, NetworkReport& network) {
    const auto found = std::ranges::find(network.computers, node.computer, &ComputerReport::name);
    return found != network.computers.end()
               ? *found
               : network.computers.emplace_back(ComputerReport{.name = node.computer});
}

}  // namespace

NetworkReport network_of(const ActivityReport& report) {
    NetworkReport network;
    std::map<bus::NodeId, const MachineNode*> nodes;
    for (const NodeReport& each : report.nodes) {
        nodes.emplace(each.node.id, &each.node);
        if (!each.node.computer.empty()) {
            ComputerReport& computer = computer_of(each.node, network);
            ++computer.nodes;
            computer.cpu_ms += each.cpu_ms;
        }
    }
    if (network.computers.empty()) {
        return network;
    }
    std::map<bus::Body, std::uint64_t> kinds;
    for (const NodeReport& each : report.nodes) {
        for (const bus::SentCount& sent : each.sent) {
            const auto to = nodes.find(sent.to);  // An io process runs beside the host.
            if (to == nodes.end() || to->second->place == each.node.place) {
                continue;
            }
            computer_of(each.node, network).sent_bytes += sent.bytes;
            computer_of(*to->second, network).received_bytes += sent.bytes;
            kinds[sent.kind] += sent.bytes;
            network.bytes += sent.bytes;
        }
    }
    for (const auto& [kind, bytes] : kinds) {
        network.kinds.push_back({kind, bytes});
    }
    std::ranges::stable_sort(network.kinds, std::greater(), &NetworkReport::Kind::bytes);
    return network;
}

}  // namespace pxpl5::host
