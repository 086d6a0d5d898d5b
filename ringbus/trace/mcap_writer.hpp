// Writes an MCAP file: chunks of messages, then the summary.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "ringbus/trace/mcap.hpp"

namespace pxpl5::bus::trace::mcap {

/// Content of the file before the first message.
struct Preamble {
    std::string library;        ///< Name of the writing library.
    std::string metadata_name;  ///< Name of the only metadata record.
    Metadata metadata;
    std::string schema_name, encoding;       ///< Name of the only schema; encoding of all messages.
    std::span<const std::uint8_t> schema{};  ///< Used only by the constructor.
};

/// One file. After a failure the file ends behind the last complete record, and every further call
/// fails with the same text.
class Writer {
  public:
    /// Creates or replaces the file and writes the preamble. Throws TraceError.
    Writer(const std::filesystem::path& path, const Preamble& preamble);
    /// Leaves the file without its end unless close() was called.
    ~Writer();
    Writer(const Writer&) = delete;
    Writer& operator=(const Writer&) = delete;

    /// Adds a channel to the current chunk. Returns the channel's id.
    std::uint16_t channel(const std::string& topic, const Metadata& metadata);
    /// Appends to the current chunk and writes a full chunk. Throws TraceError.
    void message(std::uint16_t channel, std::uint32_t sequence, std::uint64_t log_time,
                 std::span<const std::uint8_t> data);
    /// Writes the current chunk. Throws TraceError.
    void end_chunk();
    /// Ends the chunk, then the file. Throws TraceError.
    void close();

    std::uint64_t messages() const;
    std::uint64_t bytes() const;  ///< Written so far.

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace pxpl5::bus::trace::mcap
