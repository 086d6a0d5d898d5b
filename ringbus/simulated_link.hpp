// The whole machine in one thread: every message delayed and reordered by a seed.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>
#include <vector>

#include "ringbus/node.hpp"
#include "ringbus/wire.hpp"

namespace pxpl5::bus {

/// A fault that the simulated ring plants in one message, to show that it is noticed.
enum class Damage : std::uint8_t { none, drop, repeat, flip_bit, flip_header_bit };

struct SimulatedFault {
    Damage damage = Damage::none;
    std::uint64_t message = 0;  ///< Which message to damage, counted over the whole ring.
};

/// Thrown when the ring does not come to what was waited for.
struct SimulationStuck : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Nodes and the messages between them. The order between two nodes is kept, as on the wire;
/// between different senders it is drawn from the seed, and so is when nodes do a piece of their
/// work. AskActivity is answered for them. Messages cross as bytes: header and body are copied,
/// verified, and numbered as between processes.
class SimulatedRing {
  public:
    explicit SimulatedRing(std::uint64_t seed, SimulatedFault fault = {});

    /// The node is not owned and outlives the ring's run.
    void add(NodeId id, Node& node);
    /// Ring order and parameters for the stamps of every node added so far.
    void set_model(const ChannelModel& model);
    /// From here on `tap` sees every message that is about to be handed to node `to`.
    using Tap = std::function<void(NodeId to, const Message&)>;
    void on_delivery(Tap tap) { tap_ = std::move(tap); }
    /// Puts a message on the ring as if `from` had sent it.
    void send(NodeId from, NodeId to, const Payload& payload);

    /// One delivery, or one piece of one node's work. Returns false if there is nothing to do.
    bool step();
    /// Steps until `done`. Throws SimulationStuck if nothing is left to do first, or after too many
    /// steps.
    void run_until(const std::function<bool()>& done);
    /// Steps until nothing is left to do. Throws SimulationStuck after too many steps.
    void run_until_idle();

    /// What `id` has sent and received.
    Traffic traffic(NodeId id) const { return members_.at(id).wire->traffic(); }

    /// Deliveries so far, as (source, destination).
    const std::vector<std::pair<NodeId, NodeId>>& log() const { return log_; }

  private:
    struct InFlight {
        schema::Header header;
        std::vector<std::uint64_t> body;  ///< 8-byte aligned copy.
        std::size_t size = 0;
    };
    struct Member {
        Node* node = nullptr;
        std::unique_ptr<Wire> wire;
        std::unique_ptr<StageClock> clock;
        bool busy = false;
    };
    class RingOutbox;

    void deliver_front(std::pair<NodeId, NodeId> route);
    void damage(std::deque<InFlight>& queue);
    std::vector<std::pair<NodeId, NodeId>> routes_with_mail() const;
    std::vector<NodeId> busy_members() const;

    std::mt19937_64 random_;
    SimulatedFault fault_;
    std::uint64_t sent_ = 0;
    std::map<NodeId, Member> members_;
    std::map<std::pair<NodeId, NodeId>, std::deque<InFlight>> queues_;
    std::vector<std::pair<NodeId, NodeId>> log_;
    Tap tap_;
};

}  // namespace pxpl5::bus
