// Shared memory of a sender. Receivers on the same host read large bodies in it.
//
//   builder --allocate--> Arena --lend--> ArenaPlace in a message --> ArenaView::body --> Message
//                           ^----------------- ticket given back -----------------------------'
//
// The sender writes a body before it lends the body, and never afterwards. Receivers trust the
// sender in this one respect and verify a body in place. They trust nothing else of the sender.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "ringbus/message.hpp"
#include "ringbus/zmq/arena_blocks.hpp"
#include "ringbus/zmq/arena_layout.hpp"

namespace pxpl5::bus {

/// The sender's side. It takes no memory before the first large body. If the system gives no shared
/// memory, or limits the address space, bodies come from the heap and are never lent.
///
/// One thread uses it. Only deallocate() may run in ZeroMQ's thread, which may drop a body's last
/// owner.
class Arena final : public flatbuffers::Allocator {
  public:
    /// lendable_bytes  Bytes of the arena for bodies; further bodies come from the heap.
    ///                 A multiple of ArenaBlocks::grain_bytes, at most arena_bytes.
    explicit Arena(std::size_t lendable_bytes = arena_bytes);
    /// Requires that all own bodies are released. Receivers keep the bodies that they borrowed.
    ~Arena() override;
    Arena(const Arena&) = delete;
    Arena& operator=(const Arena&) = delete;

    /// Allocates a body: from the arena if the body is large and fits, else from the heap.
    std::uint8_t* allocate(std::size_t bytes) override;
    void deallocate(std::uint8_t* memory, std::size_t bytes) override;

    /// Returns true if the body is in the arena.
    bool can_lend(const Payload& payload) const;
    /// Describes the arena to receivers. Requires that a body has been allocated in the arena.
    const ArenaOffer& offer() const { return offer_; }
    /// Lends a body to `reader` until the reader returns it. Returns nothing if the reader has not
    /// opened the arena, or if no ticket is left. The body then travels inside the message.
    std::optional<ArenaPlace> lend(NodeId reader, const Payload& payload);
    /// Takes back all bodies that `reader` borrowed. Its process must have ended.
    void forget(NodeId reader);
    /// Returns the memory between and above the bodies in use to the system. Memory above them is
    /// returned without this call, too, but only after thousands of bodies.
    void return_memory();

  private:
    struct Loan {
        Payload payload;
        NodeId reader = 0;
    };

    bool open();
    bool contains(const std::uint8_t* memory) const;
    /// Releases the bodies whose tickets were returned.
    void collect();
    bool touch(std::size_t end);
    void trim();
    void punch(std::size_t begin, std::size_t end) const;

    enum class State : std::uint8_t { unopened, open, unavailable } state_ = State::unopened;
    ArenaOffer offer_;
    int file_ = -1;
    ArenaControl* control_ = nullptr;
    std::uint8_t* bodies_ = nullptr;

    std::mutex blocks_mutex_;
    ArenaBlocks blocks_;
    std::size_t touched_ = 0;        ///< Bytes from the start that certainly have memory.
    std::size_t reached_ = 0;        ///< Bytes from the start of which some have memory.
    std::size_t recently_used_ = 0;  ///< End of the highest block since the last trim().
    std::uint32_t allocations_ = 0;  ///< Since the last trim().

    std::vector<std::optional<Loan>> loans_;  ///< By ticket.
    std::vector<std::uint32_t> tickets_;      ///< Free tickets; the next is the last.
};

/// A receiver's side: another node's arena, mapped.
class ArenaView : public std::enable_shared_from_this<ArenaView> {
  public:
    /// Opens the arena of `offer` and marks node `self` as its reader. Returns null if this process
    /// cannot open the file, or if the file is no arena.
    static std::shared_ptr<ArenaView> open(const ArenaOffer& offer, NodeId self);
    ~ArenaView();
    ArenaView(const ArenaView&) = delete;
    ArenaView& operator=(const ArenaView&) = delete;

    /// Returns an owner of the lent body. The owner returns the ticket at its end. Null if the
    /// ticket is not lent to this node, or already has an owner.
    std::shared_ptr<const void> hold(std::uint32_t ticket);
    /// Returns the body that `header` announces. The bytes are valid while the ticket has an owner.
    /// Throws BadMessage if the body is not inside the arena, or if the ticket does not exist.
    std::span<const std::uint8_t> body(const schema::Header& header, const ArenaPlace& place) const;

  private:
    explicit ArenaView(NodeId self) : self_(self) {}
    void give_back(std::uint32_t ticket);

    NodeId self_;
    ArenaControl* control_ = nullptr;
    const std::uint8_t* bodies_ = nullptr;
};

}  // namespace pxpl5::bus
