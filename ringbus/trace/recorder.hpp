// The flight recorder of one node: keeps what the node receives, and writes it when asked.
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

/// How much a recorder keeps.
struct Limits {
    std::chrono::nanoseconds span = std::chrono::seconds(10);
    std::size_t share_bytes = std::size_t{64} << 20;     ///< Of messages, the newest.
    std::size_t window_bytes = std::size_t{64} << 20;    ///< With all of the last two frames.
    std::size_t setup_bytes = std::size_t{64} << 20;     ///< Of what came before and still holds.
    std::uint64_t file_bytes = std::uint64_t{16} << 30;  ///< Of a full recording, which ends then.
};

/// When something happened: by the calendar, and by a clock that is never set.
struct Instant {
    std::uint64_t wall_ns = 0;
    std::chrono::steady_clock::time_point steady;
    static Instant now();
};

/// Keeps received messages by the mode: the newest, or all (straight into the file).
///
/// A flight recorder keeps beside the newest messages those of set-up that still hold: Topology,
/// the current volume or scene, the newest SetSurface of each surface (held.cpp). So its file can
/// be replayed from its first whole frame. Slices beyond `setup_bytes` are given up; VolumeHeader
/// says where they came from.
class Recorder {
  public:
    /// How long messages of a full recording may wait for their file.
    static constexpr std::chrono::milliseconds patience{250};

    /// `info.recording` is flight or full. A full recording creates `path` at once, in a folder
    /// that is there, a flight at save(). Throws TraceError.
    Recorder(std::filesystem::path path, const Info& info, Limits limits = {});
    ~Recorder();
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;

    /// Notes a received message. Costs no copy of its body while flying.
    ///
    /// Throws TraceError when the file takes no more, or has reached its limit: once, and nothing
    /// is noted from then on.
    void note(const Message& message, Instant when = Instant::now());
    /// Whether messages wait for their file, so that idle() has something to do.
    bool has_unwritten() const;
    /// Nothing has come for a while: writes what waits. Throws TraceError as note() does.
    void idle();

    struct Saved {
        std::uint64_t messages = 0, bytes = 0;
    };
    /// Writes what is held, a flight under a temporary name first. The recorder goes on.
    /// Throws TraceError, also for a recording that had to stop.
    Saved save();
    /// Ends a full recording in order; a flight is not saved. Throws TraceError.
    void close();

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

/// A link that records what it hands on, but for what onlookers say (traffic.hpp), and obeys
/// SaveTrace by itself. When recording fails, the host gets a Fault, and the node goes on.
class RecordingLink final : public Link {
  public:
    /// Told of every received message, in order: whether the trace shall do without it.
    using LeaveOut = std::function<bool(const Message&)>;

    /// Both outlive it.
    RecordingLink(Link& link, Recorder& recorder, LeaveOut leave_out = {})
        : link_(link), recorder_(recorder), leave_out_(std::move(leave_out)) {}

    NodeId id() const override { return link_.id(); }
    const std::string& endpoint() const override { return link_.endpoint(); }
    void add_peer(NodeId id, const std::string& endpoint) override { link_.add_peer(id, endpoint); }
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
