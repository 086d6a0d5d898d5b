#include "host/machine/handshake.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "host/machine/port.hpp"

namespace pxpl5::host {

namespace {

[[noreturn]] void refuse(const std::string& text) {
    throw MachineError(ExitCode::unavailable, text);
}

}  // namespace

Handshake::Handshake(Roster nodes, Identity own)
    : nodes_(std::move(nodes)), own_(std::move(own)), connected_(nodes_.size(), false) {}

void Handshake::hello(bus::NodeId id, const bus::schema::Hello& hello) {
    RosterEntry said;
    said.role = hello.role();
    said.index = hello.index();
    const std::string name = said.name();
    const auto node = std::find_if(nodes_.begin(), nodes_.end(), [&said](const RosterEntry& n) {
        return n.role == said.role && n.index == said.index;
    });
    if (node == nodes_.end()) {
        refuse(
            fmt::format("process {} says that it is {}, which was not started", hello.pid(), name));
    }
    if (node->id != id) {
        refuse(fmt::format("node {} says that it is {}, which is node {}", id, name, node->id));
    }
    if (node->pid == 0) {
        node->pid = static_cast<int>(hello.pid());  // On another computer.
    }
    if (static_cast<int>(hello.pid()) != node->pid) {
        refuse(fmt::format("process {} says that it is {}, which is process {}", hello.pid(), name,
                           node->pid));
    }
    if (!node->endpoint.empty()) {
        refuse(fmt::format("{} said Hello twice", name));
    }
    if (hello.build()->str() != own_.build) {
        refuse(fmt::format("{} is of build '{}', the host of build '{}'", name,
                           hello.build()->str(), own_.build));
    }
    if (hello.schema_hash() != own_.schema_hash) {
        refuse(fmt::format("{} has messages of schema {:016x}, the host of schema {:016x}", name,
                           hello.schema_hash(), own_.schema_hash));
    }
    if (hello.endpoint()->size() == 0) {
        refuse(fmt::format("{} does not say where it can be reached", name));
    }
    node->endpoint = hello.endpoint()->str();
    if (hello.near_endpoint() != nullptr) {
        node->near_endpoint = hello.near_endpoint()->str();
    }
}

void Handshake::connected(bus::NodeId id) {
    const auto node = std::find_if(nodes_.begin(), nodes_.end(),
                                   [id](const RosterEntry& n) { return n.id == id; });
    if (node == nodes_.end()) {
        refuse(fmt::format("node {} says that it is connected, but was not started", id));
    }
    connected_[static_cast<std::size_t>(node - nodes_.begin())] = true;
}

std::vector<std::string> Handshake::without_hello() const {
    std::vector<std::string> names;
    for (const RosterEntry& node : nodes_) {
        if (node.endpoint.empty()) {
            names.push_back(node.name());
        }
    }
    return names;
}

std::vector<std::string> Handshake::unconnected() const {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        if (!connected_[i]) {
            names.push_back(nodes_[i].name());
        }
    }
    return names;
}

}  // namespace pxpl5::host
