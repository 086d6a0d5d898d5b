#include "host/serve/server/server_loop.hpp"

#include <fmt/format.h>
#include <libwebsockets.h>

#include <algorithm>
#include <array>

#include "host/base/error.hpp"

namespace pxpl5::host::serve {
namespace {

constexpr std::size_t chunk_bytes = 64U << 10U;  // Of uploads and files.
constexpr const char* content_policy =
    "default-src 'self'; img-src 'self' blob: data:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'";

int call_loop(lws* connection, lws_callback_reasons reason, void* /*user*/, void* data,
              std::size_t size) {
    lws_context* context = lws_get_context(connection);
    auto* loop = context == nullptr ? nullptr : static_cast<Loop*>(lws_context_user(context));
    return loop == nullptr ? 0 : loop->on_event(connection, reason, data, size);
}

const std::array<lws_protocols, 2> protocols{
    {{"pxpl5", call_loop, 0, chunk_bytes, 0, nullptr, 0}, {nullptr, nullptr, 0, 0, 0, nullptr, 0}}};

void make_folder(const std::filesystem::path& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) {
        throw RequestError(ExitCode::failed, fmt::format("cannot make the folder '{}': {}",
                                                         folder.string(), error.message()));
    }
}

RouteFolders folders_of(const ServerOptions& options) {
    RouteFolders folders = built_in_folders();
    if (!options.page.empty()) {
        folders.page = options.page;
        folders.bundle.clear();
    }
    folders.downloads = options.downloads;
    return folders;
}

}  // namespace

Loop::Loop(const ServerOptions& options, Mail& mail)
    : mail_(mail),
      routes_(folders_of(options)),
      uploads_(options.uploads),
      listener_(options, protocols.data(), content_policy, this) {
    make_folder(options.uploads);
    make_folder(options.downloads);
}

void Loop::run() {
    // Without an end of its own: libwebsockets sleeps until a connection, a timer or wake().
    while (!stopping_ && lws_service(listener_.context(), 0) >= 0) {
    }
    if (!stopping_) {
        mail_.push(Lost{"the web server cannot go on: its service of connections has failed"});
    }
}

void Loop::wake() {
    lws_cancel_service(listener_.context());
}

void Loop::stop() {
    stopping_ = true;
    wake();
}

int Loop::on_event(lws* connection, int reason, void* data, std::size_t size) {
    const std::string_view bytes(static_cast<const char*>(data), data == nullptr ? 0 : size);
    // Nothing may be thrown through libwebsockets: a connection that cannot be served is closed.
    try {
        if (reason == LWS_CALLBACK_EVENT_WAIT_CANCELLED) {
            deliver();
            return 0;
        }
        if (reason == LWS_CALLBACK_SERVER_NEW_CLIENT_INSTANTIATED) {
            strangers_.meet(connection);
            return 0;
        }
        if (reason == LWS_CALLBACK_TIMER && strangers_.has(connection)) {
            return -1;
        }
        if (reason == LWS_CALLBACK_WSI_DESTROY) {
            forget(connection);
            return 0;
        }
        const int socket = on_socket_event(connection, reason, bytes);
        return socket != 0 ? socket : on_http_event(connection, reason, bytes);
    } catch (const std::exception&) {
        return -1;
    }
}

void Loop::deliver() {
    for (const std::string& path : mail_.collect_opened()) {
        uploads_.opened(path);
    }
    for (const Outgoing& message : mail_.collect()) {
        for (auto& [connection, socket] : sockets_) {
            if (!socket.joined || socket.viewer.closing.code != 0 ||
                (message.viewer != 0 && message.viewer != socket.viewer.number)) {
                continue;
            }
            socket.viewer.line_up(message);
            lws_callback_on_writable(connection);
            if (socket.viewer.closing.code != 0) {
                close_soon(connection);
            }
        }
    }
    const auto newest = mail_.newest();
    if (newest->shown.rests) {
        resting_pixels_ = newest->shown.pixels.size();
    } else {
        moving_layers_ = static_cast<std::size_t>(newest->shown.layers);
    }
    for (auto& [connection, socket] : sockets_) {
        if (socket.viewer.takes(*mail_.newest(socket.viewer.number))) {
            lws_callback_on_writable(connection);
        }
    }
    advise();
}

double Loop::scale_for(Viewer& viewer, const Shown& form) {
    const double whole = static_cast<double>(form.pixels.size()) / (form.scale * form.scale);
    return form.rests ? 1 : viewer.link.scale(static_cast<std::size_t>(whole));
}

/// Ignores drivers who no longer acknowledge frames, for example in a hidden tab, unless no driver
/// acknowledges any.
double Loop::advised_scale() {
    double fastest = 0, of_all = 0;
    for (auto& [connection, socket] : sockets_) {
        Viewer& viewer = socket.viewer;
        if (socket.joined && viewer.role == Role::driver &&
            viewer.number != mail_.wearer().viewer) {
            const auto layers = viewer.wants_depths ? moving_layers_ : 1;
            const double scale = viewer.link.scale(layers * resting_pixels_);
            of_all = std::max(of_all, scale);
            fastest = viewer.link.is_stalled(now_ms()) ? fastest : std::max(fastest, scale);
        }
    }
    return fastest > 0 ? fastest : of_all > 0 ? of_all : 1;
}

void Loop::advise() {
    const Wearer wearer = mail_.wearer();
    const auto newest = mail_.newest(), newest_pair = mail_.newest(wearer.viewer);
    Wants wants;
    wants.frame_sequence = newest->sequence;
    wants.pair_sequence = newest_pair->sequence;
    LinkAdvice& advice = wants.advice;
    for (auto& [connection, socket] : sockets_) {
        Viewer& viewer = socket.viewer;
        if (!socket.joined) {
            continue;
        }
        if (viewer.number == wearer.viewer) {
            wants.pair = viewer.wants_newer(*newest_pair);
            const auto layers = static_cast<std::size_t>(newest_pair->shown.layers);
            advice.pair_scale = viewer.link.scale(layers * wearer.pair_pixels);
            continue;
        }
        wants.frame = wants.frame || viewer.wants_newer(*newest);
        advice.wants_depths = advice.wants_depths || viewer.wants_depths;
    }
    if (resting_pixels_ > 0) {
        advice.scale = advised_scale();
    }
    mail_.advise(wants);
}

}  // namespace pxpl5::host::serve
