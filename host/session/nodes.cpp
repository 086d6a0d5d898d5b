#include "host/session/nodes.hpp"

#include <fmt/format.h>

#include "host/base/error.hpp"
#include "host/base/nearest.hpp"

namespace pxpl5::host {

Nodes::Nodes(Conversation& conversation)
    : conversation_(conversation), activity_(conversation.machine().nodes()) {
    conversation_.handle(bus::Body::Activity, [this](const bus::Message& message) {
        activity_.take(message.source(), *message.as<bus::schema::Activity>());
    });
}

ActivityReport Nodes::activity(AwaitAnswers await) {
    conversation_.take_arrived();
    MachinePort& machine = conversation_.machine();
    for (const bus::NodeId node : activity_.ask()) {
        machine.send(node, bus::pack(bus::schema::AskActivityT{}));
    }
    if (await == AwaitAnswers::all) {
        conversation_.wait("activity", [this] { return !activity_.awaits(); });
    } else {
        conversation_.take_arrived();
    }
    return activity_.report(machine.traffic());
}

SavedTraces Nodes::save_traces() {
    SavedTraces saved = conversation_.machine().save_traces();
    if (!saved.missing.empty()) {
        throw RequestError(
            ExitCode::failed,
            fmt::format("{} of {} nodes have written no trace: {}", saved.missing.size(),
                        saved.missing.size() + static_cast<std::size_t>(saved.nodes),
                        fmt::join(saved.missing, "; ")));
    }
    return saved;
}

void Nodes::kill(const std::string& name) {
    std::vector<std::string_view> names;
    for (const MachineNode& node : activity_.nodes()) {
        if (node.id == bus::host_id) {
            continue;
        }
        if (node.name == name) {
            conversation_.machine().kill(node.id);
            return;
        }
        names.push_back(node.name);
    }
    if (name == "host" || name.starts_with("io-")) {
        throw RequestError(
            ExitCode::usage,
            fmt::format("{} cannot be killed from here: only GPs, Renderers and frame buffers can",
                        name));
    }
    throw RequestError(ExitCode::usage,
                       fmt::format("there is no node '{}'{}", name, did_you_mean(name, names)));
}

}  // namespace pxpl5::host
