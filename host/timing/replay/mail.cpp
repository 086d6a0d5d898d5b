#include "host/timing/replay/mail.hpp"

namespace pxpl5::host::timing {

Places::Places(const Machine& machine)
    : gps(machine.gps),
      renderers(machine.renderers),
      ports(machine.frame_buffers * static_cast<std::size_t>(machine.frame_buffer_ports)) {}

void Mail::send(Place source, Place destination, std::uint64_t words, Callback<> taken) {
    std::uint32_t letter = 0;
    if (free_letters_.empty()) {
        letter = static_cast<std::uint32_t>(letters_.size());
        letters_.emplace_back();
    } else {
        letter = free_letters_.back();
        free_letters_.pop_back();
    }
    letters_[letter] = {source, destination, words, taken};
    const Ns now = events_.now();
    if (source == places_.host()) {
        events_.at(host_.add(now, costs_.host_message()), [this, letter] { from_host(letter); });
    } else if (places_.is_gp(source)) {
        events_.at(gps_[source - places_.gp(0)].message(costs_.gp_message()),
                   [this, letter] { to_ring(letter); });
    } else {
        to_ring(letter);
    }
}

Ns Mail::crossed(std::uint32_t letter) {
    return link_.add(events_.now(), costs_.link(letters_[letter].words));
}

void Mail::from_host(std::uint32_t letter) {
    events_.at(crossed(letter), [this, letter] { to_ring(letter); });
}

void Mail::to_ring(std::uint32_t letter) {
    RingMessage message;
    message.source = letters_[letter].source;
    message.destination = letters_[letter].destination;
    message.words = letters_[letter].words;
    message.arrives = [this, letter](Packet packet) {
        if (packet.last) {
            arrive(letter);
        }
    };
    ring_.send(message);
}

void Mail::arrive(std::uint32_t letter) {
    const Place destination = letters_[letter].destination;
    if (destination == places_.host()) {
        events_.at(crossed(letter), [this, letter] { to_host(letter); });
    } else if (places_.is_gp(destination)) {
        events_.at(gps_[destination - places_.gp(0)].message(costs_.gp_message()),
                   [this, letter] { take(letter); });
    } else {
        take(letter);
    }
}

void Mail::to_host(std::uint32_t letter) {
    events_.at(host_.add(events_.now(), costs_.host_message()), [this, letter] { take(letter); });
}

void Mail::take(std::uint32_t letter) {
    Callback<> taken = letters_[letter].taken;
    free_letters_.push_back(letter);
    taken();
}

}  // namespace pxpl5::host::timing
