// Reads an MCAP file from the front, up to the first damage.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "ringbus/trace/mcap.hpp"
#include "ringbus/trace/mcap_chunk.hpp"

namespace pxpl5::bus::trace::mcap {

/// Called by walk(). Each function may throw Damage for content that it cannot use.
struct Visitor {
    std::function<void(const std::string& name, const Metadata&)> metadata;
    /// chunk    Offset of the message's chunk record in the file.
    /// message  Only the beginning of a long message, see for_each_message().
    std::function<void(std::uint64_t chunk, const MessageRecord& message)> message;
    /// Called behind the messages of each chunk that is whole.
    std::function<void()> chunk_end;
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

    /// Visits metadata and messages in the order of the file, up to its end or the first damage.
    /// Returns "" for a complete file with valid checksums, else the reason for the early end.
    std::string walk(const Visitor& visitor) const;
    /// Returns the records in the chunk at `offset`. Throws Damage.
    Bytes chunk(std::uint64_t offset) const;

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace pxpl5::bus::trace::mcap
