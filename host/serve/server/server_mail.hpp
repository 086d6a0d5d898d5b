// Messages between the session's thread and the server's thread.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "host/serve/server/server.hpp"

namespace pxpl5::host::serve {

/// A message to a viewer, or to all.
struct Outgoing {
    std::uint32_t viewer = 0;  ///< 0: all.
    bool binary = false;
    std::shared_ptr<const std::string> bytes;
};

/// The newest frame for all, or for the wearer of a headset. `sequence` counts frames of both kinds
/// from 1; 0: none yet.
struct NewestFrame {
    std::uint64_t sequence = 0;
    Shown shown;
    /// For a resting frame: a moving frame of the same revision that has layers; may be null.
    /// Viewers who warp pictures get it, too.
    std::shared_ptr<const Shown> layers = nullptr;
};

/// The frames that viewers would take now.
struct Wants {
    bool frame = false;  ///< Some viewer accepts a newer frame for all.
    std::uint64_t frame_sequence = 0;
    bool pair = false;  ///< The wearer of the headset accepts a newer pair.
    std::uint64_t pair_sequence = 0;
    LinkAdvice advice;
};

/// The viewer who wears a headset.
struct Wearer {
    std::uint32_t viewer = 0;     ///< 0: no viewer.
    std::size_t pair_pixels = 0;  ///< Pixels of a pair at full size.
};

inline constexpr std::size_t max_waiting_event_bytes = 32U << 20U;

/// Locks are short: no thread waits for an encoder or a socket.
class Mail {
  public:
    Mail();
    ~Mail();
    Mail(const Mail&) = delete;
    Mail& operator=(const Mail&) = delete;

    // The session's side.
    int event_fd() const { return event_fd_; }
    std::vector<Event> take();
    void send(Outgoing message);
    void show(Shown frame);
    void opened(std::string path);
    void wear(std::uint32_t viewer, std::size_t pair_pixels);
    bool wants_frame() const { return wants_frame_; }
    bool wants_pair() const { return wants_pair_; }
    LinkAdvice advice() const { return {scale_, wants_depths_, pair_scale_}; }

    // The server's side.
    /// False, and nothing kept, if the session lags by max_waiting_event_bytes of texts.
    bool push(Event event);
    std::vector<Outgoing> collect();
    std::vector<std::string> collect_opened();
    /// The newest frame for that viewer: a pair if it wears a headset. Viewer 0 wears none.
    std::shared_ptr<const NewestFrame> newest(std::uint32_t viewer = 0) const;
    Wearer wearer() const;
    /// A want is ignored if a newer frame has been shown in the meantime.
    void advise(const Wants& wants);

    /// Called after send(), show(), wear() and opened(), on the session's thread.
    std::function<void()> wake_server;

  private:
    void wake_session();
    bool take_back(const Left& left);

    int event_fd_ = -1;
    mutable std::mutex mutex_;
    std::vector<Event> events_;
    std::size_t event_bytes_ = 0;
    std::vector<Outgoing> outgoing_;
    std::vector<std::string> opened_;
    std::uint64_t frames_ = 0;
    std::shared_ptr<const NewestFrame> newest_, newest_pair_;
    Wearer wearer_;
    std::atomic<bool> wants_frame_ = false, wants_pair_ = false;
    std::atomic<double> scale_ = 1, pair_scale_ = 1;
    std::atomic<bool> wants_depths_ = false;
};

}  // namespace pxpl5::host::serve
