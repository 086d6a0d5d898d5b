// Large bodies on one host: memory of a sender, in which its receivers read.
//
//   builder --allocate--> Arena --lend--> ArenaPlace in a message --> ArenaView::body --> Message
//                           ^----------------- ticket given back -----------------------------'
//
// The sender writes a body before it lends it, and never after: one of our own processes, it is
// trusted in that, and receivers verify a body where it lies. Nothing else of it is trusted.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "ringbus/arena_blocks.hpp"
#include "ringbus/arena_layout.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::bus {

/// The sender's side. It costs nothing until the first large body. Where the system gives no shared
/// memory, or a limit on address space is set, bodies come from the heap and are never lent.
///
/// One thread uses it, except deallocate(): ZeroMQ's thread may drop the last owner of a body.
class Arena final : public flatbuffers::Allocator {
  public:
    /// lendable_bytes  That much of it is given out for bodies, beyond that the heap. A multiple of
    ///                 ArenaBlocks::grain_bytes, at most arena_bytes.
    explicit Arena(std::size_t lendable_bytes = arena_bytes);
    /// All bodies are gone. Receivers keep what they have borrowed.
    ~Arena() override;
    Arena(const Arena&) = delete;
    Arena& operator=(const Arena&) = delete;

    /// For a body, from the arena if it is large and there is room, else from the heap.
    std::uint8_t* allocate(std::size_t bytes) override;
    void deallocate(std::uint8_t* memory, std::size_t bytes) override;

    /// Whether such a body lies where it can be lent.
    bool can_lend(const Payload& payload) const;
    /// How to find the arena, which exists since a body was in it.
    const ArenaOffer& offer() const { return offer_; }
    /// Lends a body to `reader` until that gives it back. Returns nothing if the reader has not
    /// opened the arena, or no ticket is left; then the body travels inside the message.
    std::optional<ArenaPlace> lend(NodeId reader, const Payload& payload);
    /// `reader`, a process that has ended, gives nothing back any more.
    void forget(NodeId reader);

  private:
    struct Loan {
        Payload payload;
        NodeId reader = 0;
    };

    bool open();
    bool contains(const std::uint8_t* memory) const;
    /// Drops the bodies whose tickets have come back.
    void collect();
    bool touch(std::size_t end);
    void trim();

    enum class State : std::uint8_t { unopened, open, unavailable } state_ = State::unopened;
    ArenaOffer offer_;
    int file_ = -1;
    ArenaControl* control_ = nullptr;
    std::uint8_t* bodies_ = nullptr;

    std::mutex blocks_mutex_;
    ArenaBlocks blocks_;
    std::size_t touched_ = 0;        ///< Bytes from the beginning that have memory.
    std::size_t recently_used_ = 0;  ///< Where blocks have ended since the last trim().
    std::uint32_t allocations_ = 0;  ///< Likewise.

    std::vector<std::optional<Loan>> loans_;  ///< By ticket.
    std::vector<std::uint32_t> tickets_;      ///< Not out; the next one last.
};

/// A receiver's side: another node's arena, mapped.
class ArenaView : public std::enable_shared_from_this<ArenaView> {
  public:
    /// Opens what `offer` leads to, and lets its owner know that node `self` reads it. Returns null
    /// if this process cannot reach it, or if it is no arena.
    static std::shared_ptr<ArenaView> open(const ArenaOffer& offer, NodeId self);
    ~ArenaView();
    ArenaView(const ArenaView&) = delete;
    ArenaView& operator=(const ArenaView&) = delete;

    /// An owner of what was lent: gives the ticket back at its end. Null if the ticket is not lent
    /// to this node, or is held already.
    std::shared_ptr<const void> hold(std::uint32_t ticket);
    /// The body that `header` announces, as long as it is held. Throws BadMessage if it would not
    /// lie in the arena, or its ticket is none.
    std::span<const std::uint8_t> body(const schema::Header& header, const ArenaPlace& place) const;

  private:
    explicit ArenaView(NodeId self) : self_(self) {}
    void give_back(std::uint32_t ticket);

    NodeId self_;
    ArenaControl* control_ = nullptr;
    const std::uint8_t* bodies_ = nullptr;
};

}  // namespace pxpl5::bus
