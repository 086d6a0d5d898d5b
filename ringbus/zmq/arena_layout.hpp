// Layout of a sender's shared memory, for the sender and its receivers on the same host.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "ringbus/message.hpp"

namespace pxpl5::bus {

/// Address space for the bodies of one sender. Only blocks in use take memory.
inline constexpr std::size_t arena_bytes = std::size_t{512} << 20;
/// Smaller bodies travel inside their messages, because copying them costs less than lending.
inline constexpr std::size_t min_arena_body_bytes = 4096;
/// Lent bodies of one sender at a time, counted once per receiver.
inline constexpr std::uint32_t max_tickets = 4096;
inline constexpr std::uint32_t no_ticket = max_tickets;
inline constexpr std::size_t arena_page_bytes = 4096;
/// Nodes from this id on receive bodies inside the messages. The rest of the first page of
/// ArenaControl has one byte per node: 75 times the nodes of `paper-1993`.
inline constexpr NodeId max_arena_readers = arena_page_bytes - 2 * sizeof(std::uint32_t);

/// State of a ticket. Only the sender lends it. Only the borrower reads and returns it, and only
/// once. So no other node can free a body that is being read.
using TicketState = std::uint16_t;
inline constexpr TicketState ticket_free = 0;
inline constexpr TicketState being_read = 0x8000;
constexpr TicketState lent_to(NodeId reader) {
    return static_cast<TicketState>(reader + 1);
}
constexpr TicketState read_by(NodeId reader) {
    return lent_to(reader) | being_read;
}
static_assert(lent_to(max_arena_readers) < being_read);

/// The only part of an arena that receivers write. They return tickets in a linked list: each
/// receiver adds its tickets in front, and the sender takes the whole list.
struct ArenaControl {
    std::atomic<std::uint32_t> returned{no_ticket};  ///< First ticket of the list.
    std::uint32_t reserved = 0;
    std::array<std::atomic<std::uint8_t>, max_arena_readers> is_read_by{};  ///< By node id.
    std::array<std::atomic<TicketState>, max_tickets> states{};             ///< By ticket.
    std::array<std::atomic<std::uint32_t>, max_tickets> next{};             ///< By ticket.
};
static_assert(sizeof(ArenaControl) % arena_page_bytes == 0, "bodies begin on a page");
static_assert(std::atomic<std::uint32_t>::is_always_lock_free, "processes share it");

inline constexpr std::size_t arena_file_bytes = sizeof(ArenaControl) + arena_bytes;

/// Tells a receiver how to open the sender's arena. Follows the header of an ordinary message.
struct ArenaOffer {
    /// Identity of the file, so that a process id of another computer does not match.
    std::uint64_t device = 0;
    std::uint64_t inode = 0;
    std::uint32_t pid = 0;
    std::uint32_t descriptor = 0;  ///< The sender's open file.
};

/// Place of a message's body in the sender's arena. Follows the header instead of a body.
struct ArenaPlace {
    std::uint64_t offset = 0;  ///< Bytes.
    std::uint32_t ticket = 0;  ///< The receiver returns it after use.
    std::uint32_t reserved = 0;
};
static_assert(sizeof(ArenaOffer) != sizeof(ArenaPlace),
              "what follows a header says so by its size");

}  // namespace pxpl5::bus
