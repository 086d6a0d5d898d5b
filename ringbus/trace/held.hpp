// The set-up messages that still apply to a node. A flight recorder keeps them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ringbus/message.hpp"

namespace pxpl5::bus::trace {

/// A message and the time of its receipt.
struct Held {
    Message message;
    std::uint64_t wall_ns = 0;
};

/// The set-up of a node. A new message replaces the messages that no longer apply. The table in
/// held.cpp has the rules.
class HeldSetup {
  public:
    /// Keeps at most `limit_bytes` of bulk messages such as slices. Beyond the limit it keeps none.
    explicit HeldSetup(std::size_t limit_bytes) : limit_bytes_(limit_bytes) {}

    /// Takes the next message that the node received. Returns the number of dropped messages, which
    /// may include this message.
    std::uint64_t take(Held held);

    /// Messages in the order of receipt.
    const std::vector<Held>& messages() const { return held_; }

  private:
    template <typename Test>
    void drop(const Test& test);

    std::size_t limit_bytes_;
    std::size_t bulk_bytes_ = 0;
    bool bulk_refused_ = false;  ///< Until the next volume or scene begins.
    std::vector<Held> held_;
};

}  // namespace pxpl5::bus::trace
