#include "ringbus/node_loop.hpp"

#include <new>

#include "ringbus/activity.hpp"
#include "ringbus/wire.hpp"

namespace pxpl5::bus {

namespace {

constexpr int quiet_ms = 1000;

using schema::FaultCode;

/// Source of the work that fails, as far as the driver knows it.
struct Origin {
    NodeId source = host_id;
    std::uint64_t sequence = 0;
    FaultCause cause{};
};

/// Runs `act` and sends what it throws to the host as a Fault. A cause that the node names takes
/// precedence over the driver's.
template <typename Act>
void guarded(NodeId self, const Origin& origin, Outbox& out, const Act& act) {
    const auto report = [&](FaultCode code, const std::string& reason, const FaultCause& named) {
        out.send(host_id, fault_message(self, origin.source, origin.sequence, code, reason,
                                        named.request == Body::NONE ? origin.cause : named));
    };
    try {
        act();
    } catch (const NodeFault& fault) {
        report(fault.code, fault.what(), fault.cause);
    } catch (const std::bad_alloc&) {
        report(FaultCode::out_of_memory, memory_exhausted, {});
    }
}

}  // namespace

Payload fault_message(NodeId node, NodeId source, std::uint64_t sequence, FaultCode code,
                      const std::string& reason, FaultCause cause) {
    schema::FaultT fault;
    fault.code = code;
    fault.node = node;
    fault.source = source;
    fault.sequence = sequence;
    fault.reason = reason;
    fault.frame = cause.frame;
    fault.request = static_cast<std::uint16_t>(cause.request);
    return pack(fault);
}

std::optional<Message> receive_or_report(Link& link, Outbox& out) {
    const auto report = [&](const auto& bad, FaultCode code) {
        out.send(host_id,
                 fault_message(link.id(), bad.source, bad.sequence, code, bad.what(), bad.cause));
    };
    while (true) {
        try {
            return link.receive();
        } catch (const BadMessage& bad) {
            report(bad, FaultCode::bad_message);
        } catch (const WireFault& fault) {
            report(fault, fault.code);
        }
    }
}

void deliver(Node& node, NodeId self, const Message& message, Outbox& out) {
    const StageClock::In receiving(out.clock(), stage::receive);
    guarded(self, {message.source(), message.header().sequence(), cause_of(message)}, out,
            [&] { node.receive(message, out); });
}

bool work_once(Node& node, NodeId self, Outbox& out) {
    const StageClock::In working(out.clock(), stage::work);
    bool more = true;  // Other work may remain after a fault.
    guarded(self, {self}, out, [&] { more = node.work(out); });
    return more;
}

bool run_node(Node& node, Link& link, const std::function<bool()>& alive, Pulse& pulse) {
    StageClock clock;
    LinkOutbox out(link, &clock);
    const auto rest = [&] {
        const StageClock::In waiting(&clock, stage::wait);
        pulse.enter(Phase::waiting, node.doing());
        return link.wait(quiet_ms);
    };
    clock.enter(stage::receive);
    bool busy = true;
    while (true) {
        while (const std::optional<Message> message = receive_or_report(link, out)) {
            if (message->kind() == Body::Shutdown) {
                return true;
            }
            if (message->kind() == Body::AskActivity) {
                out.send(host_id,
                         activity_message(clock, link.traffic(), node.status(), link.queued()));
                continue;
            }
            pulse.enter(Phase::receiving, {message->kind()});
            deliver(node, link.id(), *message, out);
            busy = true;
        }
        // A receiver that is behind does not need more messages, so the node does no work.
        const bool held_up = link.queued() > 0;
        if (busy && !held_up) {
            pulse.enter(Phase::working, node.doing());
            busy = work_once(node, link.id(), out);
        }
        if ((!busy || held_up) && !rest() && !alive()) {
            return false;
        }
    }
}

}  // namespace pxpl5::bus
