// A trace file: the messages that one node received, in order, as an MCAP file.
//
// One MCAP message per received message; its data is a schema::TraceEntry (schema/trace.fbs, which
// travels in the file), its log time the wall clock at receipt, its sequence the low 32 bits of the
// sender's logical clock. One MCAP channel per sender and kind: topic "/gp-3/RegionPrograms".
// Source: MCAP format specification, https://mcap.dev/spec.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "ringbus/message.hpp"
#include "ringbus/trace/error.hpp"

namespace pxpl5::bus::trace {

/// Describes a trace. Stored as an MCAP metadata record named "pxpl5".
struct Info {
    std::string build;              ///< build_id() of the program that recorded.
    std::uint64_t schema_hash = 0;  ///< Hash of the message schemas.
    NodeId node = 0;                ///< The receiver of the messages.
    schema::Role role = schema::Role::host;
    std::uint16_t index = 0;  ///< Within the role.
    Recording recording = Recording::full;
    std::uint64_t dropped = 0;  ///< Messages that the flight recorder had dropped before the save.
    std::map<std::string, std::string> more;  ///< For example isa_hash, topology (resolved JSON).
    std::string node_name() const;            ///< "gp-3".
};

/// Writes one trace file in zstd chunks of whole messages. Flushed chunks stay readable after a
/// kill.
class TraceWriter {
  public:
    /// Creates or replaces `path`. Throws TraceError.
    TraceWriter(const std::filesystem::path& path, const Info& info);
    /// Leaves the file without its end, but readable, if close() has not been called.
    ~TraceWriter();
    TraceWriter(const TraceWriter&) = delete;
    TraceWriter& operator=(const TraceWriter&) = delete;

    /// Appends a message and writes a full chunk. Throws TraceError.
    void add(const Message& message, std::uint64_t wall_ns);
    /// Writes the current chunk. Throws TraceError.
    void flush();
    /// Flushes, then writes index, statistics and footer. add() must not follow.
    void close();

    std::uint64_t messages() const;  ///< Number of added messages.
    std::uint64_t bytes() const;     ///< Size of the file.

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

/// A recorded message without its body.
struct Entry {
    schema::Header header;
    std::uint64_t wall_ns = 0;
    std::uint64_t chunk = 0;   ///< File offset of its chunk record.
    std::uint64_t offset = 0;  ///< Offset of the message record in the uncompressed chunk.

    Body kind() const { return static_cast<Body>(header.kind()); }
};

/// Reads a trace file, up to its end or the first damage.
class TraceFile {
  public:
    /// Reads the file once and keeps the entries without their bodies. Throws TraceError if `path`
    /// is no trace of this program, has another schema hash, or ends before its metadata.
    explicit TraceFile(const std::filesystem::path& path);
    ~TraceFile();
    TraceFile(TraceFile&&) noexcept;
    TraceFile& operator=(TraceFile&&) noexcept;

    const Info& info() const;
    const std::vector<Entry>& entries() const;  ///< In the order of receipt.
    /// Returns "" for a complete file, else the reason for the early end, with its offset.
    const std::string& cut() const;
    /// Returns the verified message of an entry. Caches the newest chunk, so reading in order is
    /// fast. Throws TraceError, BadMessage.
    Message load(const Entry& entry) const;

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace pxpl5::bus::trace
