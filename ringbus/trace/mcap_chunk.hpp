// The messages in a chunk record of an MCAP file.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "ringbus/trace/mcap.hpp"

namespace pxpl5::bus::trace::mcap {

/// A message record.
struct MessageRecord {
    std::uint64_t offset = 0;  ///< In the records of the chunk.
    std::uint64_t log_time = 0;
    std::uint64_t data_bytes = 0;        ///< Size of the whole data.
    std::span<const std::uint8_t> data;  ///< The data, or their begin.
};

/// Bytes of a message's data that for_each_message() hands over.
inline constexpr std::size_t max_begin_bytes = std::size_t{64} << 10;

/// Unpacks the content of a chunk record and calls back for each message, in order, with at most
/// the first max_begin_bytes of its data. Takes little memory, whatever the chunk claims to hold.
/// A chunk must be one that a writer writes: all records begin within a full chunk, and only a
/// message ends beyond it. Throws Damage, also after messages were handed over.
void for_each_message(std::span<const std::uint8_t> content,
                      const std::function<void(const MessageRecord&)>& take);

/// Returns the records in the content of a chunk record. Throws Damage.
Bytes chunk_records(std::span<const std::uint8_t> content);

/// Returns the message record at `offset` of a chunk's records. Throws Damage if none is there.
MessageRecord message_at(std::span<const std::uint8_t> records, std::uint64_t offset);

}  // namespace pxpl5::bus::trace::mcap
