// Reads an MCAP file from the front, up to the first damage.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "ringbus/trace/mcap.hpp"

namespace pxpl5::bus::trace::mcap {

/// Called by walk(). Each function may throw Damage for content that it cannot use.
struct Visitor {
    std::function<void(const std::string& name, const Metadata&)> metadata;
    /// offset   Offset of the chunk record in the file.
    /// records  Content of the chunk.
    std::function<void(std::uint64_t offset, std::span<const std::uint8_t> records)> chunk;
};

class Reader {
  public:
    /// Throws TraceError if the file cannot be read or does not begin like an MCAP file.
    explicit Reader(const std::filesystem::path& path);
    ~Reader();
    Reader(Reader&&) noexcept;
    Reader& operator=(Reader&&) noexcept;

    const std::filesystem::path& path() const;
    std::uint64_t size() const;  ///< Bytes of the file.

    /// Visits metadata and chunks in the order of the file, up to its end or the first damage.
    /// Returns "" for a complete file with valid checksums, else the reason for the early end.
    std::string walk(const Visitor& visitor) const;
    /// Returns the content of the chunk record at `offset`. Throws Damage.
    Bytes chunk(std::uint64_t offset) const;

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

/// A message record.
struct MessageRecord {
    std::uint64_t offset = 0;  ///< In the content of the chunk.
    std::uint64_t log_time = 0;
    std::span<const std::uint8_t> data;
};

/// Returns the message record at `offset` of a chunk's content. Throws Damage if none is there.
MessageRecord message_at(std::span<const std::uint8_t> records, std::uint64_t offset);

/// Calls back for each message of a chunk, in order. Throws Damage.
void for_each_message(std::span<const std::uint8_t> records,
                      const std::function<void(const MessageRecord&)>& take);

}  // namespace pxpl5::bus::trace::mcap
