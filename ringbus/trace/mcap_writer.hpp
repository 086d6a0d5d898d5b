// Writes an MCAP file: chunks of messages as they come, the summary at the end.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "ringbus/trace/mcap.hpp"

namespace pxpl5::bus::trace::mcap {

/// What the file says about itself before the first message.
struct Preamble {
    std::string library;        ///< Who wrote it.
    std::string metadata_name;  ///< Of the only metadata record.
    Metadata metadata;
    std::string schema_name, encoding;       ///< Of the only schema, and of all messages.
    std::span<const std::uint8_t> schema{};  ///< Outlives the writer's construction.
};

/// One file. After a failure it ends on the border of the last record that was written whole, and
/// every further call fails with the same words.
class Writer {
  public:
    /// Creates or replaces the file and writes the preamble. Throws TraceError.
    Writer(const std::filesystem::path& path, const Preamble& preamble);
    /// Leaves the file as it is: without its end unless close() was called.
    ~Writer();
    Writer(const Writer&) = delete;
    Writer& operator=(const Writer&) = delete;

    /// A new channel; its record goes into the chunk under way. Returns its id.
    std::uint16_t channel(const std::string& topic, const Metadata& metadata);
    /// Appends to the chunk under way; a full chunk goes to the file. Throws TraceError.
    void message(std::uint16_t channel, std::uint32_t sequence, std::uint64_t log_time,
                 std::span<const std::uint8_t> data);
    /// Sends the chunk under way to the file. Throws TraceError.
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
