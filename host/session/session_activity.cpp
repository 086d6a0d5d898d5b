// What a session knows of its machine's inside: what nodes do, and how one dies.
#include <fmt/format.h>

#include <utility>

#include "host/base/error.hpp"
#include "host/base/nearest.hpp"
#include "host/session/activity_text.hpp"
#include "host/session/session.hpp"

namespace pxpl5::host {

ActivityReport Session::activity(AwaitAnswers await) {
    take_what_is_here();
    for (const bus::NodeId node : activity_.ask()) {
        machine_.send(node, bus::pack(bus::schema::AskActivityT{}));
    }
    if (await == AwaitAnswers::all) {
        wait("activity", [this] { return !activity_.awaits(); });
    } else {
        take_what_is_here();
    }
    return activity_.report(machine_.traffic());
}

/// Takes the messages that have come, and waits for none. Throws RequestError if one is a fault:
/// nobody asked for what it is of, and the next request must not be blamed for it.
void Session::take_what_is_here() {
    bool came = true;
    machine_.pump(
        [&](const bus::Message& message) {
            came = true;
            on_message(message);
        },
        [&] { return !std::exchange(came, false); });
    wait("told unasked", [] { return true; });  // Throws what has come.
}

void Session::kill_node(const std::string& name) {
    std::vector<std::string_view> names;
    for (const MachineNode& node : activity_.nodes()) {
        if (node.id == bus::host_id) {
            continue;
        }
        if (node.name == name) {
            machine_.kill(node.id);
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

Fields activity_fields(Session& session) {
    return activity_fields(session.activity(AwaitAnswers::none), session.last_frame());
}

}  // namespace pxpl5::host
