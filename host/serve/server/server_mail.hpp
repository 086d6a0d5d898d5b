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

/// The newest frame. `sequence` counts frames from 1, over all viewers.
struct NewestFrame {
    std::uint64_t sequence = 0;
    Shown shown;
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
    bool wants_frame() const { return wants_frame_; }
    LinkAdvice advice() const { return {scale_, wants_depths_}; }

    // The server's side.
    /// False, and nothing kept, if the session lags by max_waiting_event_bytes of texts.
    bool push(Event event);
    std::vector<Outgoing> collect();
    std::vector<std::string> collect_opened();
    std::shared_ptr<const NewestFrame> newest() const;
    /// wanted  A viewer accepts a frame newer than number `sequence`. Ignored if a newer frame
    ///         has been shown in the meantime.
    void advise(bool wanted, std::uint64_t sequence, LinkAdvice advice);

    /// Called after send(), show() and opened(), on the session's thread.
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
    std::shared_ptr<const NewestFrame> newest_;
    std::atomic<bool> wants_frame_ = false;
    std::atomic<double> scale_ = 1;
    std::atomic<bool> wants_depths_ = false;
};

}  // namespace pxpl5::host::serve
