// One viewer: what waits to be sent to it, how much it may say, which frames it has.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "host/serve/encoding/link_rate.hpp"
#include "host/serve/server/server_mail.hpp"
#include "host/serve/video/video_encoder.hpp"

namespace pxpl5::host::serve {

inline constexpr std::size_t max_viewers = 8;
inline constexpr std::size_t max_watchers = max_viewers - 1;  ///< A place is kept for a driver.
inline constexpr std::size_t max_watchers_at_address = 2;     ///< From another computer.
inline constexpr std::size_t max_video_viewers = 2;           ///< At once; others get JPEG.
inline constexpr std::size_t max_text_bytes = 64U << 10U;     // Of a message to the server.
inline constexpr double messages_per_second = 400;            // Of a viewer, on average.
inline constexpr double messages_at_once = 800;
inline constexpr std::size_t max_waiting_bytes = 8U << 20U;  // For a viewer.
inline constexpr std::size_t max_unacknowledged_frames = 2;  // One on its way, one displayed.
/// A viewer's first picture, if it rests and has more bytes, follows a preview of its own.
inline constexpr std::size_t preview_above_bytes = 64U << 10U;

/// A WebSocket's close code with its sentence of at most 123 bytes. Source: RFC 6455, 7.4.
struct CloseReason {
    int code = 0;  ///< 0: stay open.
    std::string text;
};

/// Milliseconds of the clock that the times of viewers are of. It never goes back.
double now_ms();

/// Times are those of now_ms().
class Viewer {
  public:
    Viewer(std::uint32_t its_number, Role its_role) : number(its_number), role(its_role) {}

    const std::uint32_t number;
    const Role role;
    LinkRate link;
    CloseReason closing;        ///< Once set, it is closed at the next chance.
    bool wants_depths = false;  ///< Its frames carry depths, if the machine has read them.
    bool wants_video = false;   ///< It can show video.
    std::unique_ptr<VideoEncoder> video;  ///< Set while its moving frames are video.

    /// Adds a part of a message. Returns the whole once `is_final`, nothing before and nothing
    /// (closing is set then) if it is too long or too many have come.
    std::optional<std::string> hear(std::string_view part, bool is_final, double now_ms);

    /// Lines up a message; sets closing if too many bytes wait. A message is never too long alone.
    void line_up(Outgoing message);
    std::optional<Outgoing> next_message();
    bool has_messages() const { return !messages_.empty(); }

    /// Whether the frame is news to it, and it has room for one. The first message is a text, in
    /// which the session greets the viewer.
    bool takes(const NewestFrame& frame) const { return has_room() && next_of(frame) != nullptr; }
    /// The picture of the frame that it gets next: the frame itself, or its layers. Null if it has
    /// both.
    const Shown* next_of(const NewestFrame& frame) const;
    /// Sets wants_depths. A viewer that asks for depths gets the newest frame again if the frame
    /// has any: they may have asked after the frame was sent.
    void want_depths(bool wanted, const NewestFrame& newest);
    /// Whether it would take a frame newer than this one.
    bool wants_newer(const NewestFrame& frame) const;
    /// Notes that next_of(frame) goes out now; returns its number for this viewer.
    std::uint32_t count_frame(const NewestFrame& frame);
    bool has_had_frames() const { return frames_ > 0; }
    /// The number of a preview of next_of(frame), which still goes out itself afterwards.
    std::uint32_t count_preview() { return ++frames_; }

  private:
    bool has_room() const;
    /// Sequence of the newest sent frame of the same kind: for all, or for a headset.
    std::uint64_t newest_sent(const NewestFrame& frame) const {
        return frame.shown.viewer == 0 ? newest_sent_ : newest_pair_sent_;
    }

    std::string heard_;
    double may_say_ = messages_at_once;
    double last_heard_ms_ = 0;
    std::deque<Outgoing> messages_;
    std::size_t waiting_bytes_ = 0;
    bool is_greeted_ = false;
    std::uint64_t newest_sent_ = 0, newest_pair_sent_ = 0;
    std::uint32_t layers_sent_ = 0;  ///< Revision of the newest layers; 0: none.
    std::uint32_t frames_ = 0;
};

/// A frame that a viewer has displayed, so long after the frame arrived.
struct ShownFrame {
    std::uint32_t number = 0;
    double since_arrival_ms = 0;
};

/// The frame in `{"shown":123}` or `{"shown":123,"after_ms":7}`, if the text is that message.
std::optional<ShownFrame> shown_frame(const std::string& text);
/// The value in `{"depths":true}`, if the text is that message.
std::optional<bool> wanted_depths(const std::string& text);
/// The value in `{"video":true}`, if the text is that message.
std::optional<bool> wanted_video(const std::string& text);

}  // namespace pxpl5::host::serve
