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

/// What makes a trace self-contained; an MCAP metadata record named "pxpl5".
struct Info {
    std::string build;              ///< build_id() of the program that recorded.
    std::uint64_t schema_hash = 0;  ///< Of the message schemas.
    NodeId node = 0;                ///< Whose messages these are.
    schema::Role role = schema::Role::host;
    std::uint16_t index = 0;  ///< Within the role.
    schema::Recording recording = schema::Recording::full;
    std::uint64_t dropped = 0;  ///< Messages that the flight recorder had given up before the save.
    std::map<std::string, std::string> more;  ///< E.g. isa_hash, topology (resolved JSON).
    std::string node_name() const;            ///< "gp-3".
};

/// Writes one trace file, in zstd chunks that end on message borders: what has been flushed stays
/// readable whatever happens to the process.
class TraceWriter {
  public:
    /// Creates or replaces `path`. Throws TraceError.
    TraceWriter(const std::filesystem::path& path, const Info& info);
    /// Leaves the file without its end, but readable, if close() has not been called.
    ~TraceWriter();
    TraceWriter(const TraceWriter&) = delete;
    TraceWriter& operator=(const TraceWriter&) = delete;

    /// Appends; a full chunk goes to the file. Throws TraceError.
    void add(const Message& message, std::uint64_t wall_ns);
    /// Ends the chunk under way and hands it to the system. Throws TraceError.
    void flush();
    /// Flushes, writes index, statistics and footer. Nothing can be added afterwards.
    void close();

    std::uint64_t messages() const;  ///< Added so far.
    std::uint64_t bytes() const;     ///< Of the file so far.

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

/// What is known of a recorded message without loading its body again.
struct Entry {
    schema::Header header;
    std::uint64_t wall_ns = 0;
    std::uint64_t chunk = 0;   ///< File offset of its chunk record.
    std::uint64_t offset = 0;  ///< Of the message record within the uncompressed chunk.

    Body kind() const { return static_cast<Body>(header.kind()); }
};

/// Reads a trace file. A file that ends early, or is damaged, is read up to there.
class TraceFile {
  public:
    /// Reads everything once and keeps the entries, not the bodies.
    /// Throws TraceError if `path` is no MCAP file of ours, or of another schema hash, or ends
    /// before it says what it is.
    explicit TraceFile(const std::filesystem::path& path);
    ~TraceFile();
    TraceFile(TraceFile&&) noexcept;
    TraceFile& operator=(TraceFile&&) noexcept;

    const Info& info() const;
    const std::vector<Entry>& entries() const;  ///< In the order of receipt.
    /// Empty for a file that was closed; else why the rest is not there, with the offset.
    const std::string& cut() const;
    /// The message of an entry, verified. The newest chunk is kept, so order is speed.
    /// Throws TraceError, BadMessage.
    Message load(const Entry& entry) const;

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace pxpl5::bus::trace
