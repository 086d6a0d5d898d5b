// What a sender and its receivers on the same host agree on about the sender's shared memory.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "ringbus/message.hpp"

namespace pxpl5::bus {

/// Of one sender, for its bodies. Address space; of memory it takes what is in use.
inline constexpr std::size_t arena_bytes = std::size_t{512} << 20;
/// Smaller bodies travel inside their messages: there, copying costs less than lending.
inline constexpr std::size_t min_arena_body_bytes = 4096;
/// Bodies of one sender that may be out at a time, counted once for each receiver.
inline constexpr std::uint32_t max_tickets = 4096;
inline constexpr std::uint32_t no_ticket = max_tickets;
inline constexpr std::size_t arena_page_bytes = 4096;
/// Nodes from this id on get their bodies inside the messages. What is left of the first page of
/// ArenaControl, a byte for each: 75 times the nodes of `paper-1993`.
inline constexpr NodeId max_arena_readers = arena_page_bytes - 2 * sizeof(std::uint32_t);

/// Where a ticket is. Only the sender lends, only the node it was lent to reads and gives back, and
/// that once: nobody else can free a body that is being read.
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

/// The only part of an arena that its receivers write. They give tickets back as a linked list:
/// each adds its own in front, the sender takes them all at once.
struct ArenaControl {
    std::atomic<std::uint32_t> returned{no_ticket};  ///< First of the list.
    std::uint32_t reserved = 0;
    std::array<std::atomic<std::uint8_t>, max_arena_readers> is_read_by{};  ///< By node id.
    std::array<std::atomic<TicketState>, max_tickets> states{};             ///< By ticket.
    std::array<std::atomic<std::uint32_t>, max_tickets> next{};             ///< By ticket.
};
static_assert(sizeof(ArenaControl) % arena_page_bytes == 0, "bodies begin on a page");
static_assert(std::atomic<std::uint32_t>::is_always_lock_free, "processes share it");

inline constexpr std::size_t arena_file_bytes = sizeof(ArenaControl) + arena_bytes;

/// Where a receiver finds a sender's arena. Follows the header of an ordinary message.
struct ArenaOffer {
    /// Of the file, so that a process id of elsewhere leads nowhere.
    std::uint64_t device = 0;
    std::uint64_t inode = 0;
    std::uint32_t pid = 0;
    std::uint32_t descriptor = 0;  ///< The sender's open file.
};

/// Where in its sender's arena the body of a message lies. Follows the header in place of a body.
struct ArenaPlace {
    std::uint64_t offset = 0;  ///< Bytes.
    std::uint32_t ticket = 0;  ///< To be given back when the body has been used.
    std::uint32_t reserved = 0;
};
static_assert(sizeof(ArenaOffer) != sizeof(ArenaPlace),
              "what follows a header says so by its size");

}  // namespace pxpl5::bus
