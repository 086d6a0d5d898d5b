// Records the messages that one node receives and writes them to a file.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "ringbus/link.hpp"
#include "ringbus/trace/trace_file.hpp"

namespace pxpl5::bus::trace {

/// Limits of a recorder.
struct Limits {
    std::chrono::nanoseconds span = std::chrono::seconds(10);
    std::size_t share_bytes = std::size_t{64} << 20;   ///< Newest messages.
    std::size_t window_bytes = std::size_t{64} << 20;  ///< Including the last two frames.
    std::size_t setup_bytes = std::size_t{64} << 20;  ///< Earlier set-up messages that still apply.
    std::uint64_t file_bytes = std::uint64_t{16} << 30;  ///< A full recording ends at this size.
};

/// A time by the calendar and by a clock that is never set.
struct Instant {
    std::uint64_t wall_ns = 0;
    std::chrono::steady_clock::time_point steady;
    static Instant now();
};

/// Keeps the newest messages in memory (flight), or writes all messages to the file (full).
///
/// A flight recorder also keeps the set-up messages that still apply: Topology, the current volume
/// or scene, the newest SetSurface of each surface (held.cpp). So its file can be replayed from its
/// first complete frame. Slices beyond `setup_bytes` are dropped; VolumeHeader has the source of
/// the volume.
class Recorder {
  public:
    /// Time that messages of a full recording may wait for their file.
    static constexpr std::chrono::milliseconds patience{250};

    /// `info.recording` is flight or full. A full recording creates `path` at once, in an existing
    /// folder. A flight creates it at save(). Throws TraceError.
    Recorder(std::filesystem::path path, const Info& info, Limits limits = {});
    ~Recorder();
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;

    /// Records a received message. A flight does not copy the body.
    ///
    /// Throws TraceError once when the file cannot grow or has reached its limit. Later messages
    /// are not recorded.
    void note(const Message& message, Instant when = Instant::now());
    /// Returns true if messages wait for their file, so that idle() has work.
    bool has_unwritten() const;
    /// Writes waiting messages after a quiet time. Throws TraceError like note().
    void idle();

    struct Saved {
        std::uint64_t messages = 0, bytes = 0;
    };
    /// Writes the recorded messages; a flight writes to a temporary name first. Recording
    /// continues. Throws TraceError, also for a recording that has stopped.
    Saved save();
    /// Closes the file of a full recording. Does not save a flight. Throws TraceError.
    void close();

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

/// A link that records the messages that it delivers, except those of observers (traffic.hpp). It
/// answers SaveTrace itself. When recording fails, it sends a Fault to the host, and the node goes
/// on.
class RecordingLink final : public Link {
  public:
    /// Called for every received message, in order. Returns true if the trace shall omit the
    /// message.
    using LeaveOut = std::function<bool(const Message&)>;

    /// `link` and `recorder` must outlive this link.
    RecordingLink(Link& link, Recorder& recorder, LeaveOut leave_out = {})
        : link_(link), recorder_(recorder), leave_out_(std::move(leave_out)) {}

    NodeId id() const override { return link_.id(); }
    const std::string& endpoint() const override { return link_.endpoint(); }
    void add_peer(NodeId id, schema::Role role, const std::string& endpoint) override {
        link_.add_peer(id, role, endpoint);
    }
    void remove_peer(NodeId id) override { link_.remove_peer(id); }
    void send(NodeId to, Payload payload) override { link_.send(to, std::move(payload)); }
    flatbuffers::Allocator* body_allocator() override { return link_.body_allocator(); }
    std::size_t queued() const override { return link_.queued(); }
    Traffic traffic() const override { return link_.traffic(); }
    std::optional<Message> receive() override;
    bool wait(int timeout_ms) override;

  private:
    template <typename Act>
    void reporting(const Act& act);
    void answer(NodeId who);

    Link& link_;
    Recorder& recorder_;
    LeaveOut leave_out_;
};

}  // namespace pxpl5::bus::trace
