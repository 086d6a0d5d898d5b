// WebSockets: one for each viewer.
#include <fmt/format.h>
#include <libwebsockets.h>
#include <strings.h>

#include <algorithm>
#include <initializer_list>
#include <vector>

#include "host/base/kernel/standard_streams.hpp"
#include "host/serve/encoding/encode.hpp"
#include "host/serve/server/server_loop.hpp"
#include "host/serve/server/server_request.hpp"

namespace pxpl5::host::serve {
namespace {

constexpr int ping_seconds = 5;
constexpr double dead_after_ms = 60'000;  // Limit of the time without an answer to a ping.
constexpr double silent_ms = 10'000;      // The same, of a driver whose place another driver needs.
// A rejected viewer must be silent for this time before the socket closes, and its messages are
// discarded. A message to a closed socket would cause a reset, which would overtake the reason.
constexpr lws_usec_t farewell = LWS_USEC_PER_SEC / 5;
constexpr int close_timeout_seconds = 5;  // Limit for viewers that are never silent.

/// Sends the parts with libwebsockets' room before them. Returns -1 if the connection is lost.
int write_message(lws* connection, std::initializer_list<std::string_view> parts,
                  lws_write_protocol kind) {
    std::size_t size = 0;
    for (const std::string_view part : parts) {
        size += part.size();
    }
    std::vector<unsigned char> buffer(LWS_PRE + size);
    auto at = buffer.begin() + LWS_PRE;
    for (const std::string_view part : parts) {
        at = std::copy(part.begin(), part.end(), at);
    }
    return lws_write(connection, buffer.data() + LWS_PRE, size, kind) < static_cast<int>(size) ? -1
                                                                                               : 0;
}

/// Closes with a reason.
int say_why(lws* connection, const Viewer& viewer) {
    constexpr std::size_t max_reason_bytes = 123;  // RFC 6455, 5.5.
    std::string text = viewer.closing.text.substr(0, max_reason_bytes);
    lws_close_reason(connection, static_cast<lws_close_status>(viewer.closing.code),
                     reinterpret_cast<unsigned char*>(text.data()), text.size());
    return -1;
}

}  // namespace

void Loop::close_soon(lws* connection) {
    lws_set_timer_usecs(connection, farewell);
    lws_set_timeout(connection, PENDING_TIMEOUT_CLOSE_SEND, close_timeout_seconds);
}

int Loop::on_socket_event(lws* connection, int reason, std::string_view data) {
    if (reason == LWS_CALLBACK_HTTP_CONFIRM_UPGRADE) {
        // `data` may be freed already when the upgrade is not one to a WebSocket (CVE-2025-11677).
        // Apache, behind which portals stand, writes "WebSocket".
        return strcasecmp(header_of(connection, WSI_TOKEN_UPGRADE).c_str(), "websocket") == 0 ? 0
                                                                                              : -1;
    }
    if (reason == LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION) {
        return on_handshake(connection);
    }
    if (reason == LWS_CALLBACK_ESTABLISHED) {
        on_joined(connection);
        return 0;
    }
    const auto found = sockets_.find(connection);
    if (found == sockets_.end()) {
        return 0;
    }
    Socket& socket = found->second;
    switch (reason) {
        case LWS_CALLBACK_RECEIVE:
            on_text(connection, socket, data);
            return 0;
        case LWS_CALLBACK_RECEIVE_PONG:
            if (socket.pinged_ms > 0) {
                socket.viewer.link.pinged(now_ms() - socket.pinged_ms);
            }
            socket.pinged_ms = 0;
            return 0;
        case LWS_CALLBACK_SERVER_WRITEABLE:
            return on_writable(connection, socket);
        case LWS_CALLBACK_TIMER:
            return on_timer(connection, socket);
        case LWS_CALLBACK_CLOSED:
            forget(connection);
            return 0;
        default:
            return 0;
    }
}

int Loop::on_handshake(lws* connection) {
    const Request request = read_request(connection);
    Verdict verdict = judge_by_token(listener_.rules(), request);
    if (verdict.status == 200 &&
        routes_.find(request.path, listener_.port()).kind != RouteKind::socket) {
        verdict = {404, fmt::format("There is no WebSocket at {}.", request.path), {}, {}};
    }
    if (verdict.status != 200) {
        (void)answer(connection, verdict.status, "text/plain; charset=utf-8", verdict.reason);
        return -1;
    }
    strangers_.accept(connection);
    handshakes_[connection] = verdict.role;
    return 0;
}

std::string Loop::why_full(Role role, const std::string& address) const {
    std::size_t joined = 0, watchers = 0, there = 0;
    for (const auto& [connection, socket] : sockets_) {
        const bool is_watcher = socket.joined && socket.viewer.role == Role::watcher;
        joined += socket.joined ? 1 : 0;
        watchers += is_watcher ? 1 : 0;
        there += is_watcher && socket.address == address ? 1 : 0;
    }
    if (joined >= max_viewers) {
        return fmt::format("{} viewers are connected already.", max_viewers);
    }
    if (role == Role::watcher && watchers >= max_watchers) {
        return fmt::format("{} watchers are connected already.", max_watchers);
    }
    // Behind a tunnel all viewers have the loopback's address.
    if (role == Role::watcher && address != "loopback" && there >= max_watchers_at_address) {
        return fmt::format("{} watchers of this computer are connected already.",
                           max_watchers_at_address);
    }
    return "";
}

lws* Loop::silent_driver() const {
    lws* silent = nullptr;
    double since_ms = now_ms() - silent_ms;
    for (const auto& [connection, socket] : sockets_) {
        if (socket.joined && socket.viewer.role == Role::driver && socket.pinged_ms > 0 &&
            socket.pinged_ms <= since_ms) {
            silent = connection;
            since_ms = socket.pinged_ms;
        }
    }
    return silent;
}

void Loop::on_joined(lws* connection) {
    const auto handshake = handshakes_.extract(connection);
    const Role role = handshake.empty() ? Role::watcher : handshake.mapped();
    const std::string address = address_of(connection);
    std::string full = why_full(role, address);
    if (lws* silent = full.empty() || role != Role::driver ? nullptr : silent_driver()) {
        // Its computer may have been switched off, and the user has opened the page again.
        sockets_.at(silent).pinged_ms = 0;  // It gives its place once.
        lws_set_timeout(silent, PENDING_TIMEOUT_CLOSE_SEND, LWS_TO_KILL_ASYNC);
        full.clear();
    }
    const bool is_full = !full.empty();
    const std::uint32_t number = is_full ? 0 : ++viewers_;
    Socket socket{Viewer(number, role), !is_full, address};
    if (is_full) {
        socket.viewer.closing = {1013, std::move(full)};
        close_soon(connection);
    } else {
        mail_.push(Joined{number, socket.viewer.role});
        lws_set_timer_usecs(connection, 1);  // The first ping, while nothing else is on its way.
    }
    sockets_.emplace(connection, std::move(socket));
    advise();
}

void Loop::on_text(lws* connection, Socket& socket, std::string_view part) {
    Viewer& viewer = socket.viewer;
    if (viewer.closing.code != 0) {
        lws_set_timer_usecs(connection, farewell);
        return;
    }
    if (lws_frame_is_binary(connection) != 0) {
        viewer.closing = {1003, "Only text messages are accepted."};
        return close_soon(connection);
    }
    const bool is_final =
        lws_is_final_fragment(connection) != 0 && lws_remaining_packet_payload(connection) == 0;
    std::optional<std::string> text = viewer.hear(part, is_final, now_ms());
    if (viewer.closing.code != 0) {
        return close_soon(connection);
    }
    if (!text) {
        return;
    }
    if (const auto frame = shown_frame(*text)) {
        viewer.link.shown(frame->number, now_ms(), frame->since_arrival_ms);
        if (viewer.takes(*mail_.newest(viewer.number))) {
            lws_callback_on_writable(connection);
        }
        advise();
    } else if (const auto wanted = wanted_depths(*text)) {
        viewer.want_depths(*wanted && viewer.role == Role::driver, *mail_.newest());
        if (viewer.takes(*mail_.newest())) {
            lws_callback_on_writable(connection);
        }
        advise();
    } else if (const auto wants_video = wanted_video(*text)) {
        viewer.wants_video = *wants_video;
        viewer.video.reset();  // The next video frame is a key frame.
    } else if (!mail_.push(Said{viewer.number, viewer.role, std::move(*text)})) {
        viewer.closing = {1013, "Too many messages are waiting for the session."};
        close_soon(connection);
    }
}

int Loop::on_writable(lws* connection, Socket& socket) {
    Viewer& viewer = socket.viewer;
    if (viewer.closing.code != 0) {
        return socket.is_leaving ? say_why(connection, viewer) : 0;
    }
    // One message a call: then the others have their turn.
    const auto newest = mail_.newest(viewer.number);
    int result = 0;
    if (socket.ping_due) {
        socket.ping_due = false;
        socket.pinged_ms = now_ms();
        // Without a payload libwebsockets 4.1 sends none.
        result = write_message(connection, {"p"}, LWS_WRITE_PING);
    } else if (const auto message = viewer.next_message()) {
        result = write_message(connection, {*message->bytes},
                               message->binary ? LWS_WRITE_BINARY : LWS_WRITE_TEXT);
    } else if (viewer.takes(*newest)) {
        result = send_frame(connection, viewer, *newest);
    }
    advise();
    if (viewer.has_messages() || viewer.takes(*newest)) {
        lws_callback_on_writable(connection);
    }
    return result;
}

int Loop::send_frame(lws* connection, Viewer& viewer, const NewestFrame& frame) {
    const Shown& shown = *viewer.next_of(frame);
    encodings_.begin(frame);
    const auto form_for = [&](bool with_depths) {
        const Shown& form = encodings_.form_of(shown, with_depths);
        return shown.viewer == 0 ? &encodings_.in_size(form, scale_for(viewer, form)) : &form;
    };
    const bool has_depths = (viewer.wants_depths || shown.viewer != 0) && !shown.depths.empty();
    const Shown* form = form_for(has_depths);
    std::string_view depths = has_depths ? encodings_.depths(*form) : std::string_view();
    if (has_depths && depths.empty()) {
        form = form_for(false);
    }
    Encoded picture = encoded_for(viewer, *form, depths.size());
    const bool is_preview =
        shown.rests && !viewer.has_had_frames() && picture.bytes.size() > preview_above_bytes;
    if (is_preview) {
        picture = preview_of(*form);
        depths = {};
    }
    FrameHeader header;
    header.number = is_preview ? viewer.count_preview() : viewer.count_frame(frame);
    header.revision = shown.revision;
    header.width = static_cast<std::uint16_t>(form->width);
    header.height = static_cast<std::uint16_t>(form->height);
    header.kind = picture.kind;
    header.quality = static_cast<std::uint8_t>(picture.quality);
    header.samples = static_cast<std::uint8_t>(shown.samples);
    const bool is_whole = shown.rests && !is_preview;
    header.flags =
        static_cast<std::uint8_t>((is_whole ? +FrameFlag::rests : 0) |
                                  (is_whole && shown.last ? +FrameFlag::last : 0) | picture.flags);
    header.machine_ms = shown.machine_ms;
    header.moved_mm = shown.moved_mm;
    header.digest = is_preview ? 0 : shown.digest;
    header.picture_bytes = static_cast<std::uint32_t>(picture.bytes.size());
    header.depth_bytes = static_cast<std::uint32_t>(depths.size());
    header.pose = shown.pose;
    header.views = static_cast<std::uint8_t>(form->views);
    header.layers = static_cast<std::uint8_t>(form->layers);
    header.opacity = static_cast<std::uint8_t>(form->opacity);
    const std::size_t bytes = sizeof(FrameHeader) + picture.bytes.size() + depths.size();
    viewer.link.sent(header.number, bytes, now_ms(), picture.kind);
    return write_message(connection, {frame_header(header), picture.bytes, depths},
                         LWS_WRITE_BINARY);
}

/// A JPEG of a resting picture: over a slow link it comes long before the picture itself.
Loop::Encoded Loop::preview_of(const Shown& form) {
    constexpr JpegQuality quality;
    return {PictureKind::jpeg, encodings_.pictures(form, quality), quality.quality};
}

/// The pairs of a headset are no video: the page warps them, and drops late ones undecoded.
Loop::Encoded Loop::encoded_for(Viewer& viewer, const Shown& form, std::size_t depth_bytes) {
    if (form.rests) {
        return {PictureKind::png, encodings_.pictures(form, std::nullopt)};
    }
    const std::size_t pixels = form.pixels.size();
    const bool may_be_video = viewer.wants_video && form.viewer == 0 && has_place_for_video(viewer);
    if (viewer.link.uses_video(std::max(pixels, resting_pixels_), may_be_video) &&
        encode_video(viewer, form, depth_bytes)) {
        viewer.link.encoded_depths(pixels, depth_bytes);
        return {PictureKind::vp8, video_frame_.bytes, 0, video_frame_.is_key ? +FrameFlag::key : 0};
    }
    viewer.video.reset();
    const JpegQuality quality = viewer.link.quality(pixels);
    const std::string& picture = encodings_.pictures(form, quality);
    viewer.link.encoded(quality, pixels, picture.size() + depth_bytes);
    return {PictureKind::jpeg, picture, quality.quality,
            quality.full_color ? +FrameFlag::full_color : 0};
}

/// One place is kept for a driver.
bool Loop::has_place_for_video(const Viewer& viewer) const {
    std::size_t all = 0, watchers = 0;
    for (const auto& [connection, socket] : sockets_) {
        const bool has_video = socket.viewer.video != nullptr;
        all += has_video ? 1 : 0;
        watchers += has_video && socket.viewer.role == Role::watcher ? 1 : 0;
    }
    return viewer.video || (all < max_video_viewers &&
                            (viewer.role == Role::driver || watchers + 1 < max_video_viewers));
}

bool Loop::encode_video(Viewer& viewer, const Shown& form, std::size_t depth_bytes) {
    // Depths have their own size. What they leave is for the colors, but not less than a half.
    const std::size_t goal = viewer.link.video_bytes();
    try {
        if (!viewer.video) {
            viewer.video = std::make_unique<VideoEncoder>();
        }
        video_frame_ = viewer.video->encode(form.width, form.pictures() * form.height, form.pixels,
                                            goal - std::min(depth_bytes, goal / 2));
    } catch (const std::exception& error) {
        print_notice("warning", fmt::format("moving pictures are JPEG: {}", error.what()));
        viewer.wants_video = false;
    }
    return viewer.wants_video;
}

int Loop::on_timer(lws* connection, Socket& socket) {
    socket.is_leaving = socket.viewer.closing.code != 0;
    if (socket.is_leaving) {
        lws_callback_on_writable(connection);
        return 0;
    }
    const double now = now_ms();
    if (socket.pinged_ms > 0 && now - socket.pinged_ms > dead_after_ms) {
        return -1;
    }
    socket.ping_due = socket.pinged_ms == 0;
    lws_set_timer_usecs(connection, ping_seconds * LWS_USEC_PER_SEC);
    lws_callback_on_writable(connection);
    return 0;
}

void Loop::forget(lws* connection) {
    uploading_.erase(connection);
    handshakes_.erase(connection);
    strangers_.forget(connection);
    const auto socket = sockets_.extract(connection);
    if (socket.empty() || !socket.mapped().joined) {
        return;
    }
    mail_.push(Left{socket.mapped().viewer.number});
    advise();
}

}  // namespace pxpl5::host::serve
