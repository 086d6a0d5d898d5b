// Messages that a flight recorder holds: what a node was told once and still goes by.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ringbus/message.hpp"

namespace pxpl5::bus::trace {

/// A message and when it came.
struct Held {
    Message message;
    std::uint64_t wall_ns = 0;
};

/// The set-up of a node. What enters it takes the place of what no longer holds; the rules are one
/// table, in held.cpp.
class HeldSetup {
  public:
    /// No more than `limit_bytes` of bulk (slices and the like) is held; of more, none is.
    explicit HeldSetup(std::size_t limit_bytes) : limit_bytes_(limit_bytes) {}

    /// Takes the next message that the node received. Returns how many messages were given up,
    /// which may be this one.
    std::uint64_t take(Held held);

    /// In the order of receipt.
    const std::vector<Held>& messages() const { return held_; }

  private:
    template <typename Test>
    void drop(const Test& test);

    std::size_t limit_bytes_;
    std::size_t bulk_bytes_ = 0;
    bool bulk_refused_ = false;  ///< Until the next one begins.
    std::vector<Held> held_;
};

}  // namespace pxpl5::bus::trace
