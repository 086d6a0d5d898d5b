// The whole machine in one thread. A seed delays and reorders messages.
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

/// A damage that the simulated ring plants in one message, to test its detection.
enum class Damage : std::uint8_t { none, drop, repeat, flip_bit, flip_header_bit };

struct SimulatedFault {
    Damage damage = Damage::none;
    std::uint64_t message = 0;  ///< Number of the damaged message, counted over the ring.
};

/// Thrown when the ring cannot reach the awaited state.
struct SimulationStuck : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Nodes and the messages between them. Messages between two nodes stay in order, as on the wire.
/// The seed decides the order of different senders and when nodes do a piece of work. The ring
/// answers AskActivity. Messages cross as bytes: header and body are copied, verified and numbered,
/// as between processes.
class SimulatedRing {
  public:
    explicit SimulatedRing(std::uint64_t seed, SimulatedFault fault = {});

    /// The caller owns the node, which must outlive the run. A node with a role takes part by the
    /// law of senders (law.hpp): the ring drops messages between two roles that the law forbids.
    void add(NodeId id, Node& node, std::optional<schema::Role> role = std::nullopt);
    /// Sets ring order and parameters for the stamps of all nodes so far.
    void set_model(const ChannelModel& model);
    /// Calls `tap` with each message before node `to` receives it.
    using Tap = std::function<void(NodeId to, const Message&)>;
    void on_delivery(Tap tap) { tap_ = std::move(tap); }
    /// Puts a message of `from` on the ring.
    void send(NodeId from, NodeId to, const Payload& payload);

    /// Does one delivery or one piece of one node's work. Returns false if nothing remains.
    bool step();
    /// Steps until `done`. Throws SimulationStuck if nothing remains before, or after too many
    /// steps.
    void run_until(const std::function<bool()>& done);
    /// Steps until nothing remains. Throws SimulationStuck after too many steps.
    void run_until_idle();

    /// Messages that `id` has sent and received.
    Traffic traffic(NodeId id) const;

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
        std::optional<schema::Role> role;
        bool busy = false;
        std::uint64_t refused = 0;  ///< Messages that the law forbids.
    };
    class RingOutbox;

    void deliver_front(std::pair<NodeId, NodeId> route);
    bool is_lawful(const schema::Header& header, const Member& receiver) const;
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
