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
/// Of a body that is read where it lies, as finish() makes it.
inline constexpr std::uint64_t arena_body_alignment = 8;
/// Bodies of one sender that may be out at a time, counted once for each receiver.
inline constexpr std::uint32_t max_tickets = 4096;
/// Nodes from this id on get their bodies inside the messages.
inline constexpr NodeId max_arena_readers = 4088;
inline constexpr std::uint32_t no_ticket = max_tickets;
inline constexpr std::size_t arena_page_bytes = 4096;

/// The only part of an arena that its receivers write. They give tickets back as a linked list:
/// each adds its own in front, the sender takes them all at once.
struct ArenaControl {
    std::atomic<std::uint32_t> returned{no_ticket};  ///< First of the list.
    std::uint32_t reserved = 0;
    std::array<std::atomic<std::uint8_t>, max_arena_readers> is_read_by{};  ///< By node id.
    std::array<std::atomic<std::uint8_t>, max_tickets> is_out{};            ///< By ticket.
    std::array<std::atomic<std::uint32_t>, max_tickets> next{};             ///< By ticket.
};
static_assert(sizeof(ArenaControl) % arena_page_bytes == 0, "bodies begin on a page");
static_assert(std::atomic<std::uint32_t>::is_always_lock_free, "processes share it");

inline constexpr std::size_t arena_file_bytes = sizeof(ArenaControl) + arena_bytes;

/// Where a receiver finds a sender's arena. Follows the header of an ordinary message.
struct ArenaOffer {
    std::uint64_t inode = 0;  ///< Of the file, so that a process id of elsewhere leads nowhere.
    std::uint32_t pid = 0;
    std::uint32_t descriptor = 0;  ///< The sender's open file.
};

/// Where in its sender's arena the body of a message lies. Follows the header in place of a body.
struct ArenaPlace {
    std::uint64_t offset = 0;        ///< Bytes.
    std::uint32_t ticket = 0;        ///< To be given back when the body has been used.
    std::uint32_t reserved[3] = {};  ///< Makes it another size than an offer.
};
static_assert(sizeof(ArenaOffer) != sizeof(ArenaPlace));

}  // namespace pxpl5::bus
