#include "host/timing/replay/ring.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <tuple>

namespace pxpl5::host::timing {

namespace {
constexpr std::size_t bits = 64;  ///< Bits of one part of Ring::senders_.
}

Ring::Ring(const Machine& machine, const Costs& costs, Events& events, std::size_t places)
    : costs_(costs),
      events_(events),
      header_words_(static_cast<std::uint32_t>(machine.ring_header_words)),
      message_words_(static_cast<std::uint32_t>(machine.ring_message_words)),
      // A shorter one would take no packet at all.
      fifo_words_(std::max(message_words_, static_cast<std::uint32_t>(machine.ring_fifo_words))),
      hop_ns_(machine.ring_hop_ns),
      ports_(places),
      senders_((places + bits - 1) / bits),
      channels_(static_cast<std::size_t>(machine.ring_channels)) {
    assert(message_words_ >= 1);
    assert(!channels_.empty());
    for (std::size_t channel = 0; channel < channels_.size(); ++channel) {
        free_channels_.push_back(static_cast<std::uint16_t>(channel));
    }
}

void Ring::send(const RingMessage& message) {
    assert(message.words >= 1);
    assert(message.source != message.destination);
    std::uint32_t transfer = 0;
    if (free_transfers_.empty()) {
        transfer = static_cast<std::uint32_t>(transfers_.size());
        transfers_.emplace_back();
    } else {
        transfer = free_transfers_.back();
        free_transfers_.pop_back();
    }
    transfers_[transfer] = {message, 0, 0};
    wait(transfer);
}

void Ring::release(Place place, std::uint32_t words) {
    Port& port = ports_[place];
    assert(port.fifo >= words);
    const bool may_have_refused = port.fifo + message_words_ > fifo_words_;
    port.fifo -= words;
    if (may_have_refused) {
        arbitrate();
    }
}

void Ring::open(Place place, std::uint32_t gate) {
    ports_[place].gate = gate;
    arbitrate();
}

std::uint32_t Ring::next_words(const Transfer& transfer) const {
    const std::uint64_t left = transfer.message.words - transfer.sent;
    return left < message_words_ ? static_cast<std::uint32_t>(left) : message_words_;
}

bool Ring::accepts(const Transfer& transfer) const {
    const Port& port = ports_[transfer.message.destination];
    return !port.takes && port.gate >= transfer.message.gate &&
           port.fifo + next_words(transfer) <= fifo_words_;
}

void Ring::wait(std::uint32_t transfer) {
    const Place source = transfers_[transfer].message.source;
    ports_[source].waiting.push_back({events_.now(), transfer});
    senders_[source / bits] |= std::uint64_t{1} << source % bits;
    arbitrate();
}

void Ring::arbitrate() {
    while (!free_channels_.empty() && start_longest_waiting()) {
    }
}

bool Ring::start_longest_waiting() {
    Place from = 0;
    const Waiting* longest = nullptr;
    for (std::size_t part = 0; part < senders_.size(); ++part) {
        for (std::uint64_t left = senders_[part]; left != 0; left &= left - 1) {
            const std::size_t place =
                part * bits + static_cast<std::size_t>(std::countr_zero(left));
            const Waiting* waiting = longest_waiting(ports_[place]);
            // Ties go to the lower place.
            if (waiting != nullptr && (longest == nullptr || waiting->since < longest->since)) {
                from = static_cast<Place>(place);
                longest = waiting;
            }
        }
    }
    if (longest == nullptr) {
        return false;
    }
    std::vector<Waiting>& waiting = ports_[from].waiting;
    const std::uint32_t transfer = longest->transfer;
    waiting.erase(waiting.begin() + (longest - waiting.data()));
    if (waiting.empty()) {
        senders_[from / bits] &= ~(std::uint64_t{1} << from % bits);
    }
    start(transfer);
    return true;
}

const Ring::Waiting* Ring::longest_waiting(const Port& port) const {
    if (port.sends) {
        return nullptr;
    }
    const auto found = std::ranges::find_if(port.waiting, [this](const Waiting& waiting) {
        return accepts(transfers_[waiting.transfer]);
    });
    return found == port.waiting.end() ? nullptr : &*found;
}

void Ring::start(std::uint32_t index) {
    Transfer& transfer = transfers_[index];
    const RingMessage& message = transfer.message;
    Port& port = ports_[message.destination];
    const std::uint32_t words = next_words(transfer);
    const Flight flight{index, free_channels_.front(), transfer.sent + words == message.words};
    free_channels_.pop_front();
    ports_[message.source].sends = true;
    port.takes = true;
    port.fifo += words;
    transfer.sent += words;

    const Ns now = events_.now(), time = costs_.packet(words);
    channels_[flight.channel].add(now, time);
    port.taken.add(now, time);
    const std::size_t hops = (message.destination + ports_.size() - message.source) % ports_.size();
    const Ns travel = static_cast<Ns>(std::ceil(static_cast<double>(hops) * hop_ns_));
    port.last_arrival = std::max(port.last_arrival, now + time + travel);
    count(message, flight.channel, words + header_words_);
    events_.at(now + time, [this, flight] { end(flight); });
    events_.at(port.last_arrival, [this, index, words] { arrive(index, words); });
}

void Ring::end(Flight flight) {
    const RingMessage& message = transfers_[flight.transfer].message;
    ports_[message.source].sends = false;
    ports_[message.destination].takes = false;
    free_channels_.push_back(flight.channel);
    if (flight.last) {
        Callback<> left = message.left;
        if (left) {
            left();
        }
    } else {
        wait(flight.transfer);
        return;
    }
    arbitrate();
}

void Ring::arrive(std::uint32_t index, std::uint32_t words) {
    Transfer& transfer = transfers_[index];
    const Packet packet{transfer.arrived, words,
                        transfer.arrived + words == transfer.message.words};
    transfer.arrived += words;
    const RingMessage message = transfer.message;
    if (packet.last) {
        free_transfers_.push_back(index);
    }
    if (!message.stays) {
        release(message.destination, words);
    }
    Callback<Packet> arrives = message.arrives;
    arrives(packet);
}

void Ring::count(const RingMessage& message, std::uint16_t channel, std::uint32_t words) {
    const std::uint32_t pair = std::uint32_t{message.source} << 16 | message.destination;
    std::vector<RingCount>& counts = counts_[pair];
    counts.resize(channels_.size());
    ++counts[channel].messages;
    counts[channel].words += words;
}

std::vector<RingCount> Ring::counts() const {
    std::vector<RingCount> all;
    for (const auto& [pair, counts] : counts_) {
        for (std::size_t channel = 0; channel < counts.size(); ++channel) {
            RingCount count = counts[channel];
            if (count.messages > 0) {
                count.source = static_cast<Place>(pair >> 16);
                count.destination = static_cast<Place>(pair & 0xFFFF);
                count.channel = static_cast<std::uint16_t>(channel);
                all.push_back(count);
            }
        }
    }
    std::ranges::sort(
        all, {}, [](const RingCount& c) { return std::tuple(c.source, c.destination, c.channel); });
    return all;
}

}  // namespace pxpl5::host::timing
