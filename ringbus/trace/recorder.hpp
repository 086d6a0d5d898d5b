// The flight recorder of one node: keeps what the node receives, and writes it when asked.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>

#include "ringbus/link.hpp"
#include "ringbus/trace/trace_file.hpp"

namespace pxpl5::bus::trace {

/// How much the flight recorder keeps.
struct FlightLimits {
    std::chrono::nanoseconds span = std::chrono::seconds(10);
    std::size_t window_bytes = std::size_t{64} << 20;  ///< Of messages, the newest.
    std::size_t setup_bytes = std::size_t{64} << 20;   ///< Of what came before and still holds.
};

/// Keeps received messages by the mode: nothing, the newest, or all (straight into the file).
///
/// A flight recorder keeps beside the newest messages those of set-up that still hold: Topology,
/// the current volume, the newest SetSurface of each surface. So its file can be replayed from its
/// first whole frame. Slices beyond `setup_bytes` are given up; VolumeHeader says where they came
/// from.
class Recorder {
  public:
    /// `path` is written at once when recording everything, else at save(). Throws TraceError.
    Recorder(std::filesystem::path path, const Info& info, FlightLimits limits = {});
    ~Recorder();

    /// Notes a received message. Costs no copy of its body while flying. Throws TraceError.
    void note(const Message& message);
    /// Nothing is waiting for the node: a good time to flush a file.
    void idle();

    struct Saved {
        std::uint64_t messages = 0, bytes = 0;
    };
    /// Writes what is held, under a temporary name first. The recorder goes on. Throws TraceError.
    Saved save();
    /// Ends a full recording in order; a flight is not saved.
    void close();

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

/// A link that records what it hands on, and obeys SaveTrace by itself.
class RecordingLink final : public Link {
  public:
    /// Both outlive it.
    RecordingLink(Link& link, Recorder& recorder) : link_(link), recorder_(recorder) {}

    NodeId id() const override { return link_.id(); }
    const std::string& endpoint() const override { return link_.endpoint(); }
    void add_peer(NodeId id, const std::string& endpoint) override { link_.add_peer(id, endpoint); }
    void remove_peer(NodeId id) override { link_.remove_peer(id); }
    void send(NodeId to, Payload payload) override { link_.send(to, std::move(payload)); }
    std::optional<Message> receive() override;
    bool wait(int timeout_ms) override;

  private:
    Link& link_;
    Recorder& recorder_;
};

}  // namespace pxpl5::bus::trace
