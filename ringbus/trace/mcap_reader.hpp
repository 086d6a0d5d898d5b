// Reads an MCAP file from the front, as far as it is whole.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "ringbus/trace/mcap.hpp"

namespace pxpl5::bus::trace::mcap {

/// What a walk meets. Each may throw Damage for what it cannot use.
struct Visitor {
    std::function<void(const std::string& name, const Metadata&)> metadata;
    /// `offset` is the chunk record's in the file, `records` what it holds.
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

    /// Visits metadata and chunks in the order of the file, up to its end or the first damage.
    /// Returns "" for a whole file, checksums included, else why there is no more.
    std::string walk(const Visitor& visitor) const;
    /// What the chunk record at `offset` holds. Throws Damage.
    Bytes chunk(std::uint64_t offset) const;

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

/// A message record.
struct MessageRecord {
    std::uint64_t offset = 0;  ///< In the chunk's records.
    std::uint64_t log_time = 0;
    std::span<const std::uint8_t> data;
};

/// The message record at `offset` of a chunk's records. Throws Damage if there is none.
MessageRecord message_at(std::span<const std::uint8_t> records, std::uint64_t offset);

/// Hands on the messages of a chunk, in order. Throws Damage.
void for_each_message(std::span<const std::uint8_t> records,
                      const std::function<void(const MessageRecord&)>& take);

}  // namespace pxpl5::bus::trace::mcap
