// The ring: packets, ports, FIFOs, channels, and who goes first.
#pragma once

#include <cstdint>
#include <deque>
#include <unordered_map>
#include <vector>

#include "host/timing/replay/costs.hpp"
#include "host/timing/replay/events.hpp"

namespace pxpl5::host::timing {

using Place = std::uint16_t;  ///< On the ring, from 0.

/// Words of a message's body that have come.
struct Packet {
    std::uint64_t offset = 0;  ///< Offset of the first.
    std::uint32_t words = 0;
    bool last = false;
};

struct RingMessage {
    Place source = 0, destination = 0;
    std::uint64_t words = 0;   ///< Words of the body; at least 1.
    std::uint32_t gate = 0;    ///< The destination takes it once its gate is as far.
    bool stays = false;        ///< In the destination's FIFO, until released.
    Callback<Packet> arrives;  ///< For each packet, in their order.
    Callback<> left;           ///< The last packet has left its sender; may be empty.
};

/// Source: README.md, "Ring".
class Ring {
  public:
    Ring(const Machine& machine, const Costs& costs, Events& events, std::size_t places);

    void send(const RingMessage& message);
    /// Makes room in a FIFO.
    void release(Place place, std::uint32_t words);
    /// The place takes messages up to this gate from now on.
    void open(Place place, std::uint32_t gate);

    const std::vector<Meter>& channels() const { return channels_; }
    const Meter& taken_at(Place place) const { return ports_[place].taken; }
    std::vector<RingCount> counts() const;

  private:
    struct Transfer {
        RingMessage message;
        std::uint64_t sent = 0, arrived = 0;  ///< Words.
    };
    struct Waiting {
        Ns since = 0;
        std::uint32_t transfer = 0;
    };
    struct Port {
        bool sends = false, takes = false;
        std::uint32_t fifo = 0;  ///< Words in it, and on their way to it.
        std::uint32_t gate = 0;
        Ns last_arrival = 0;
        Meter taken;
        std::vector<Waiting> waiting;  ///< Messages that leave from here, longest wait first.
    };
    struct Flight {
        std::uint32_t transfer = 0;
        std::uint16_t channel = 0;
        bool last = false;
    };

    std::uint32_t next_words(const Transfer& transfer) const;
    bool accepts(const Transfer& transfer) const;
    void wait(std::uint32_t transfer);
    /// Lets packets go that may, longest waiting first.
    void arbitrate();
    bool start_longest_waiting();
    /// Returns the first packet that may leave from a port now, or null.
    const Waiting* longest_waiting(const Port& port) const;
    void start(std::uint32_t transfer);
    void end(Flight flight);
    void arrive(std::uint32_t transfer, std::uint32_t words);
    void count(const RingMessage& message, std::uint16_t channel, std::uint32_t words);

    const Costs& costs_;
    Events& events_;
    std::uint32_t header_words_, message_words_, fifo_words_;
    double hop_ns_;
    std::vector<Port> ports_;
    std::vector<std::uint64_t> senders_;  ///< A bit a place: packets wait there.
    std::vector<Meter> channels_;
    std::deque<std::uint16_t> free_channels_;  ///< Longest free first.
    std::vector<Transfer> transfers_;
    std::vector<std::uint32_t> free_transfers_;
    std::unordered_map<std::uint32_t, std::vector<RingCount>> counts_;  ///< By source, destination.
};

}  // namespace pxpl5::host::timing
