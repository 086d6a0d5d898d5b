// The server's thread: connections, requests and WebSockets, over libwebsockets.
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "host/serve/server/compressed_files.hpp"
#include "host/serve/server/frame_encodings.hpp"
#include "host/serve/server/listener.hpp"
#include "host/serve/server/routes.hpp"
#include "host/serve/server/server_mail.hpp"
#include "host/serve/server/server_uploads.hpp"
#include "host/serve/server/server_viewer.hpp"
#include "host/serve/server/strangers.hpp"

struct lws;

namespace pxpl5::host::serve {

/// Everything but wake() and stop() belongs to the thread that runs it.
class Loop {
  public:
    /// Binds. Throws as Server does.
    Loop(const ServerOptions& options, Mail& mail);
    Loop(const Loop&) = delete;
    Loop& operator=(const Loop&) = delete;

    const Listener& listener() const { return listener_; }

    void run();   ///< Until stop(). Pushes Lost if libwebsockets cannot go on.
    void wake();  ///< From any thread: there is mail.
    void stop();  ///< From any thread.

    /// Called by libwebsockets. Returns a value other than 0 to close the connection.
    int on_event(lws* connection, int reason, void* data, std::size_t size);

  private:
    /// A WebSocket. A viewer who is turned away has not joined.
    struct Socket {
        Viewer viewer;
        bool joined = false;
        std::string address = {};  ///< The viewer's computer.
        double pinged_ms = 0;      ///< 0: no ping is under way.
        bool ping_due = false;
        bool is_leaving = false;  ///< Its reason is said at the next chance.
    };
    /// A body that is being received; discarded once something is wrong.
    struct Upload {
        std::unique_ptr<UploadingFile> file;
        std::unique_ptr<UploadingFiles> files;  ///< Instead, if several come.
        std::optional<UploadError> error;
    };

    /// A picture as it goes to a viewer. The bytes are valid until the next picture is encoded.
    struct Encoded {
        PictureKind kind = PictureKind::jpeg;
        std::string_view bytes;
        int quality = 0;
        int flags = 0;  ///< Bits of FrameFlag.
    };

    // server_loop.cpp
    void deliver();
    void advise();

    // server_http.cpp
    int on_http_event(lws* connection, int reason, std::string_view data);
    int on_request(lws* connection);
    int send_file(lws* connection, const Request& request, const ServedFile& file,
                  const std::string& cookie);
    int begin_upload(lws* connection, const Request& request, bool is_several);
    int end_upload(lws* connection);
    int end_batch(lws* connection, const Request& request);

    // server_socket.cpp
    int on_socket_event(lws* connection, int reason, std::string_view data);
    int on_handshake(lws* connection);
    void on_joined(lws* connection);
    /// Why another viewer cannot join; empty if it can.
    std::string why_full(Role role, const std::string& address) const;
    /// The driver whose connection has not answered for longest, if a new driver may take its
    /// place. Null if there is none.
    lws* silent_driver() const;
    void on_text(lws* connection, Socket& socket, std::string_view part);
    /// Closes a viewer whose closing is set.
    void close_soon(lws* connection);
    int on_writable(lws* connection, Socket& socket);
    int on_timer(lws* connection, Socket& socket);
    int send_frame(lws* connection, Viewer& viewer, const NewestFrame& frame);
    /// Size that the viewer's connection carries of a moving frame, relative to the resting one.
    static double scale_for(Viewer& viewer, const Shown& form);
    /// Size of moving frames by the fastest connection of a driver who takes frames.
    double advised_scale();
    /// The pictures in the encoding that suits the viewer's link.
    Encoded encoded_for(Viewer& viewer, const Shown& form, std::size_t depth_bytes);
    Encoded preview_of(const Shown& form);
    /// Encodes into video_frame_. False if that fails; the viewer then gets no video any more.
    bool encode_video(Viewer& viewer, const Shown& form, std::size_t depth_bytes);
    bool has_place_for_video(const Viewer& viewer) const;
    void forget(lws* connection);

    Mail& mail_;
    Routes routes_;
    CompressedFiles compressed_;
    Uploads uploads_;
    std::atomic<bool> stopping_ = false;
    Strangers strangers_;
    std::map<lws*, Role> handshakes_;
    std::map<lws*, Socket> sockets_;
    std::map<lws*, Upload> uploading_;
    std::uint32_t viewers_ = 0;  ///< Number of viewers that joined so far.
    FrameEncodings encodings_;
    VideoEncoder::Frame video_frame_;  ///< The last of any viewer.
    std::size_t resting_pixels_ = 0;
    std::size_t moving_layers_ = 1;
    Listener listener_;  ///< The last: its callbacks use the others.
};

}  // namespace pxpl5::host::serve
