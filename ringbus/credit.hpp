// Flow control: limits what one node may send before the receiver grants credit.
#pragma once

#include <cstddef>
#include <cstdint>

#include "ringbus/message.hpp"

namespace pxpl5::bus {

/// A sender's window for one receiver. Two frames of the largest scenes fit.
inline constexpr std::uint32_t window_messages = 1024;
inline constexpr std::uint64_t window_bytes = std::uint64_t{512} << 20;
/// The window for slices. Slices in transit are in memory twice, and a volume may fill half of the
/// computer's memory. No node waits for the next slice, so a small window costs no time.
inline constexpr std::uint64_t slices_window_bytes = std::uint64_t{16} << 20;
/// A receiver grants credit for this much at once, because each message that wakes a process is
/// costly. It may never grant credit for less.
inline constexpr std::uint32_t batch_messages = window_messages / 4;
inline constexpr std::uint64_t batch_bytes = slices_window_bytes / 2;

/// Messages that a sender queues for a receiver without credit. More is a fault.
inline constexpr std::size_t max_waiting_messages = std::size_t{1} << 20;
inline constexpr std::uint64_t max_waiting_bytes = std::uint64_t{16} << 30;

/// Returns false for Hello, Topology, Connected, Go and Shutdown, which a node gets once, and for
/// Credit, whose number depends on the messages with credit.
constexpr bool needs_credit(Body kind) {
    return kind > Body::Credit;
}

/// Messages of one connection that a receiver stores unread. A sender that keeps to its window
/// never sends as many. The messages of other senders then stay in the memory of their sender.
inline constexpr std::uint32_t max_unread_messages = 2 * window_messages;
/// The most credit of one peer that may be unread, and the messages that a node gets once.
inline constexpr std::uint32_t max_unread_control =
    static_cast<std::uint32_t>(window_messages / batch_messages + window_bytes / batch_bytes) + 8;
static_assert(window_messages + max_unread_control < max_unread_messages);

constexpr std::uint64_t window_bytes_of(Body kind) {
    return kind == Body::Slices ? slices_window_bytes : window_bytes;
}

/// The sender's side: messages in transit.
class Window {
  public:
    /// A message of any size may leave while less than a batch is in transit. The receiver may have
    /// consumed all of it, and grants credit only after more messages.
    bool has_room(std::size_t bytes, Body kind) const {
        return messages_ < window_messages &&
               (bytes_ < batch_bytes || bytes_ + bytes <= window_bytes_of(kind));
    }
    void take(std::size_t bytes) {
        ++messages_;
        bytes_ += bytes;
    }
    /// Returns false if the receiver grants more than was taken.
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

/// The receiver's side: consumed messages without a credit yet.
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
