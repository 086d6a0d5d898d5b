// The web server: who may connect, what they say, and the pictures and texts that go to them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "host/base/shared_words.hpp"

namespace pxpl5::host::serve {

/// A driver may do everything, a watcher only look.
enum class Role : std::uint8_t { driver, watcher };

struct ServerOptions {
    std::string bind = "127.0.0.1";  ///< An address of this computer, IPv4 or IPv6.
    int port = 0;                    ///< 0: a free one.
    bool insecure = false;           ///< Bind elsewhere than on loopback without TLS.
    std::string tls_cert, tls_key;   ///< PEM files; both or neither.
    /// Hosts of portals, as browsers show them: "portal.example.edu", "portal.example.edu:8443".
    std::vector<std::string> allowed_hosts;
    std::filesystem::path page;       ///< Empty: as built in.
    std::filesystem::path uploads;    ///< Parent of the viewers' uploads; created if missing.
    std::filesystem::path downloads;  ///< Files of `/download/NAME`; created if missing.
};

/// Viewers are counted from 1; a number is never used again.
struct Joined {
    std::uint32_t viewer = 0;
    Role role = Role::watcher;
};
struct Left {
    std::uint32_t viewer = 0;
};
/// A text message, as it came; `shown` messages stay with the server.
struct Said {
    std::uint32_t viewer = 0;
    Role role = Role::watcher;
    std::string text;
};
/// The server's thread has ended by itself; the sentence says why. No viewer comes any more.
struct Lost {
    std::string reason;
};
/// Something outside of the program will end it.
struct EndsSoon {
    std::int64_t at_s = 0;  ///< Seconds since 1970; 0: unknown, but soon.
    std::string why;        ///< "job 12 reaches its time limit"
};
using Event = std::variant<Joined, Left, Said, Lost, EndsSoon>;

/// A picture without depths.
struct OnePicture {
    int width = 0, height = 0;
    SharedWords pixels;  ///< width * height, red lowest.
};

/// A frame for all viewers, or for one who wears a headset: one picture, or several of the same
/// size, from top to bottom.
struct Shown {
    /// pictures() * width * height, red lowest.
    SharedWords pixels;
    /// Depths of the pixels as FrameDone has them, from one sample; empty if they were not read.
    SharedWords depths = {};
    int width = 0, height = 0;   ///< Size of one picture.
    int views = 1;               ///< 2: the left eye's pictures, then the right eye's.
    int layers = 1;              ///< Per view; 2: opaque surfaces, then one seen through.
    int opacity = 0;             ///< Sixteenths, of the second layer; 0 without.
    std::uint32_t viewer = 0;    ///< The wearer of a headset, who alone gets the frame; 0: all.
    std::uint32_t pose = 0;      ///< Number of a headset's pose; 0: the camera of the state.
    std::uint32_t revision = 0;  ///< Revision of the state in the picture.
    int samples = 1;             ///< Samples per pixel.
    bool rests = false;          ///< A resting picture: sent lossless, to every viewer.
    bool last = false;           ///< No refinement follows.
    double scale = 1;            ///< Size relative to the picture at rest.
    bool fixed_size = false;     ///< Each of its rows is for a row of the monitor.
    float machine_ms = 0;        ///< Request to picture.
    double moved_mm = 0;         ///< Above 0: simplified; no point is farther from the surfaces.
    std::uint64_t digest = 0;    ///< 0 while moving.

    /// All pictures as one, for viewers who ask for no depths. The server's thread calls
    /// this. Empty if there is only one picture.
    std::function<OnePicture()> as_one = {};

    int pictures() const { return views * layers; }
};

/// Wishes of the viewers for the next frame.
struct LinkAdvice {
    /// Size of moving frames relative to resting frames: 1, 3/4 or 1/2. The driver with the fastest
    /// connection decides. The server reduces the frames for slower connections.
    double scale = 1;
    bool wants_depths = false;  ///< Some viewer shows pictures from newer viewpoints.
    double pair_scale = 1;      ///< Likewise of a headset's pairs, by its wearer's connection.
};

/// Serves the page and its WebSocket from a thread of its own. Every call below may be made from
/// any one thread, returns at once and never throws because of what a viewer does.
class Server {
  public:
    /// Throws RequestError: usage if the options contradict each other, unavailable naming address
    /// and reason if it cannot listen, bad_data if page or certificate cannot be read, failed if a
    /// folder cannot be made.
    explicit Server(const ServerOptions& options);
    ~Server();
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    std::string url() const;        ///< For a driver, token included.
    std::string watch_url() const;  ///< For a watcher.
    int port() const;

    /// Readable while events wait, and when wants_frame() may have become true; take() resets it.
    int event_fd() const;
    std::vector<Event> take();

    /// Adds the event. Any thread may call this.
    void warn(EndsSoon soon);

    /// Texts reach a viewer in the order of these calls, and binary messages with them. Any thread
    /// may call send() and send_binary().
    void send(std::uint32_t viewer, std::string text);
    void broadcast(std::string text);
    void send_binary(std::uint32_t viewer, std::string bytes);

    /// Sets the open path. Removes an upload that was open before. Empty: no volume is open.
    void opened(std::string path);

    /// Takes the place of a frame that has not been sent yet. A viewer who joins later gets the
    /// newest one, too. Drops a pair if its viewer has taken the headset off.
    void show(Shown frame);

    /// From now on the viewer gets pairs and no frames for all; 0: no viewer wears a headset.
    ///
    /// pair_pixels  Of a pair at full size, for advice().
    void wear(std::uint32_t viewer, std::size_t pair_pixels);

    /// Whether some viewer would take a moving frame for all now.
    bool wants_frame() const;
    /// Whether the wearer of the headset would take a pair now.
    bool wants_pair() const;
    LinkAdvice advice() const;

  private:
    class Core;
    std::unique_ptr<Core> core_;
};

}  // namespace pxpl5::host::serve
