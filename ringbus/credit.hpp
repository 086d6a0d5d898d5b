// Flow control: how much one node may have on its way to another.
#pragma once

#include <cstddef>
#include <cstdint>

#include "ringbus/message.hpp"

namespace pxpl5::bus {

/// A sender's window towards one receiver. Two frames of the largest scenes fit.
inline constexpr std::uint32_t window_messages = 1024;
inline constexpr std::uint64_t window_bytes = std::uint64_t{512} << 20;

/// Messages that keep the machine itself going take no credit, or it could not be given back.
constexpr bool needs_credit(Body kind) {
    return kind > Body::Fault;
}

/// The sender's side: what is on its way.
class Window {
  public:
    /// One message larger than the whole window may go while nothing else is on its way.
    bool has_room(std::size_t bytes) const {
        return messages_ == 0 || (messages_ < window_messages && bytes_ + bytes <= window_bytes);
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

/// The receiver's side: what it has consumed and not yet told, in batches, because a message that
/// wakes somebody costs more than what it says.
struct Consumed {
    std::uint32_t messages = 0;
    std::uint64_t bytes = 0;

    void add(std::size_t size) {
        ++messages;
        bytes += size;
    }
    bool is_due() const { return messages >= window_messages / 4 || bytes >= window_bytes / 4; }
};

}  // namespace pxpl5::bus
