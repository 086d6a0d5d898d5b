// Flow control: how much one node may have on its way to another.
#pragma once

#include <cstddef>
#include <cstdint>

#include "ringbus/message.hpp"

namespace pxpl5::bus {

/// A sender's window towards one receiver. Two frames of the largest scenes fit.
inline constexpr std::uint32_t window_messages = 1024;
inline constexpr std::uint64_t window_bytes = std::uint64_t{512} << 20;
/// The window of a volume's slices. Nobody waits for the next one of them, and what is on its way
/// is held twice: a volume may fill half of the computer's memory.
inline constexpr std::uint64_t slices_window_bytes = std::uint64_t{16} << 20;
/// The receiver tells of so much at once, because a message that wakes somebody costs more than
/// what it says. Less than this may stay untold for ever.
inline constexpr std::uint32_t batch_messages = window_messages / 4;
inline constexpr std::uint64_t batch_bytes = slices_window_bytes / 2;

/// What a sender keeps for one receiver that gives no credit; more is a fault.
inline constexpr std::size_t max_waiting_messages = std::size_t{1} << 20;
inline constexpr std::uint64_t max_waiting_bytes = std::uint64_t{16} << 30;

/// Messages that keep the machine itself going take no credit, or it could not be given back.
constexpr bool needs_credit(Body kind) {
    return kind > Body::Fault;
}

constexpr std::uint64_t window_bytes_of(Body kind) {
    return kind == Body::Slices ? slices_window_bytes : window_bytes;
}

/// The sender's side: what is on its way.
class Window {
  public:
    /// A message of any size may go while less than a batch is on its way: the receiver may have
    /// consumed all that, and will say so only after more has come.
    bool has_room(std::size_t bytes, Body kind) const {
        return messages_ < window_messages &&
               (bytes_ < batch_bytes || bytes_ + bytes <= window_bytes_of(kind));
    }
    void take(std::size_t bytes) {
        ++messages_;
        bytes_ += bytes;
    }
    /// Returns false if more comes back than was taken.
    bool give_back(std::uint32_t messages, std::uint64_t bytes) {
        if (messages > messages_ || bytes > bytes_) {
            return false;
        }
        messages_ -= messages;
        bytes_ -= bytes;
        return true;
    }

  private:
    std::uint32_t messages_ = 0;
    std::uint64_t bytes_ = 0;
};

/// The receiver's side: what it has consumed and not yet told.
struct Consumed {
    std::uint32_t messages = 0;
    std::uint64_t bytes = 0;

    void add(std::size_t size) {
        ++messages;
        bytes += size;
    }
    bool is_due() const { return messages >= batch_messages || bytes >= batch_bytes; }
};

}  // namespace pxpl5::bus
