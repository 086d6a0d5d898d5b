#include "ringbus/simulated/simulated_link.hpp"

#include <fmt/core.h>

#include <cassert>
#include <cstring>

#include "ringbus/activity.hpp"
#include "ringbus/law.hpp"
#include "ringbus/node_loop.hpp"

namespace pxpl5::bus {

namespace {

/// Far more than any test's machine needs; one that runs this long is going in circles.
constexpr std::uint64_t max_steps = 50'000'000;

}  // namespace

class SimulatedRing::RingOutbox final : public Outbox {
  public:
    using Outbox::send;
    RingOutbox(SimulatedRing& ring, NodeId from) : ring_(ring), from_(from) {}
    void send(NodeId to, Payload payload) override {
        const StageClock::In sending(clock(), stage::send);
        ring_.send(from_, to, payload);
    }
    StageClock* clock() override { return ring_.members_.at(from_).clock.get(); }

  private:
    SimulatedRing& ring_;
    NodeId from_;
};

SimulatedRing::SimulatedRing(std::uint64_t seed, SimulatedFault fault)
    : random_(seed), fault_(fault) {}

void SimulatedRing::add(NodeId id, Node& node, std::optional<schema::Role> role) {
    members_[id] = {&node, std::make_unique<Wire>(id), std::make_unique<StageClock>(), role};
}

Traffic SimulatedRing::traffic(NodeId id) const {
    const Member& member = members_.at(id);
    Traffic traffic = member.wire->traffic();
    traffic.refused_messages = member.refused;
    return traffic;
}

bool SimulatedRing::is_lawful(const schema::Header& header, const Member& receiver) const {
    if (!receiver.role || !Wire::is_ours(header)) {
        return true;  // Message's constructor names a wrong magic.
    }
    const auto sender = members_.find(header.source());
    return sender != members_.end() &&
           (!sender->second.role ||
            may_send(*sender->second.role, known_kind(header), *receiver.role));
}

void SimulatedRing::set_model(const ChannelModel& model) {
    for (auto& [id, member] : members_) {
        member.wire->set_model(model);
    }
}

void SimulatedRing::send(NodeId from, NodeId to, const Payload& payload) {
    assert(members_.count(from) == 1);
    assert(members_.count(to) == 1);
    const auto bytes = payload.bytes();
    InFlight message{members_.at(from).wire->header_for(to, payload.kind(), bytes.size()),
                     std::vector<std::uint64_t>(bytes.size() / 8 + 1), bytes.size()};
    std::memcpy(message.body.data(), bytes.data(), bytes.size());
    std::deque<InFlight>& queue = queues_[{from, to}];
    queue.push_back(std::move(message));
    if (sent_++ == fault_.message) {
        damage(queue);
    }
}

void SimulatedRing::damage(std::deque<InFlight>& queue) {
    switch (fault_.damage) {
        case Damage::none:
            break;
        case Damage::drop:
            queue.pop_back();
            break;
        case Damage::repeat:
            queue.push_back(queue.back());
            break;
        case Damage::flip_bit: {
            // The first words of a body hold its root offset and identifier: no message survives
            // that.
            const std::uint64_t bit = random_() % 64;
            queue.back().body.front() ^= std::uint64_t{1} << bit;
            break;
        }
        case Damage::flip_header_bit: {
            // The channel and the three times at the end may have other values: they are left
            // alone.
            constexpr std::size_t channel_at = 12, after_channel = 14, times_at = 32;
            std::size_t byte = random_() % (times_at - (after_channel - channel_at));
            byte += byte >= channel_at ? after_channel - channel_at : 0;
            reinterpret_cast<std::uint8_t*>(&queue.back().header)[byte] ^=
                static_cast<std::uint8_t>(1U << random_() % 8);
            break;
        }
    }
}

std::vector<std::pair<NodeId, NodeId>> SimulatedRing::routes_with_mail() const {
    std::vector<std::pair<NodeId, NodeId>> routes;
    for (const auto& [route, queue] : queues_) {
        if (!queue.empty()) {
            routes.push_back(route);
        }
    }
    return routes;
}

std::vector<NodeId> SimulatedRing::busy_members() const {
    std::vector<NodeId> busy;
    for (const auto& [id, member] : members_) {
        if (member.busy) {
            busy.push_back(id);
        }
    }
    return busy;
}

void SimulatedRing::deliver_front(std::pair<NodeId, NodeId> route) {
    auto& queue = queues_.at(route);
    auto message = std::make_shared<InFlight>(std::move(queue.front()));
    queue.pop_front();
    log_.push_back(route);
    Member& member = members_.at(route.second);
    if (!is_lawful(message->header, member)) {
        ++member.refused;
        return;
    }
    RingOutbox out(*this, route.second);
    const auto report = [&](schema::FaultCode code, const std::string& reason) {
        out.send(host_id, fault_message(route.second, route.first, message->header.sequence(), code,
                                        reason));
    };
    try {
        member.wire->accept(message->header);
        const auto* bytes = reinterpret_cast<const std::uint8_t*>(message->body.data());
        const Message verified(message->header, {bytes, message->size}, message);
        if (tap_) {
            tap_(route.second, verified);
        }
        if (verified.kind() == Body::AskActivity) {
            out.send(host_id, activity_message(*member.clock, traffic(route.second),
                                               member.node->status(), 0));
            return;
        }
        deliver(*member.node, route.second, verified, out);
        member.busy = true;
    } catch (const NodeFault& fault) {
        report(fault.code, fault.what());
    } catch (const BadMessage& bad) {
        report(schema::FaultCode::bad_message, bad.what());
    }
}

bool SimulatedRing::step() {
    const auto routes = routes_with_mail();
    const auto busy = busy_members();
    const std::size_t choices = routes.size() + busy.size();
    if (choices == 0) {
        return false;
    }
    const std::size_t choice = random_() % choices;
    if (choice < routes.size()) {
        deliver_front(routes[choice]);
    } else {
        const NodeId id = busy[choice - routes.size()];
        RingOutbox out(*this, id);
        Member& member = members_.at(id);
        member.busy = work_once(*member.node, id, out);
    }
    return true;
}

void SimulatedRing::run_until(const std::function<bool()>& done) {
    for (std::uint64_t steps = 0; !done(); ++steps) {
        if (steps == max_steps) {
            throw SimulationStuck(fmt::format("not done after {} steps", steps));
        }
        if (!step()) {
            throw SimulationStuck(fmt::format("nothing left to do after {} steps", steps));
        }
    }
}

void SimulatedRing::run_until_idle() {
    for (std::uint64_t steps = 0; step(); ++steps) {
        if (steps == max_steps) {
            throw SimulationStuck(fmt::format("still busy after {} steps", steps));
        }
    }
}

}  // namespace pxpl5::bus
