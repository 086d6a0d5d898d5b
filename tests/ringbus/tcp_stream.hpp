// Streams of bytes to a tcp port, as a stranger sends them.
#pragma once

#include <arpa/inet.h>
#include <doctest/doctest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <string>
#include <thread>

namespace pxpl5::test {

inline constexpr int stream_patience_ms = 30000;

inline int port_of(const std::string& endpoint) {
    return std::stoi(endpoint.substr(endpoint.rfind(':') + 1));
}

/// A stream to a port of this computer.
class Stream {
  public:
    explicit Stream(int port) : fd_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(static_cast<std::uint16_t>(port));
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        REQUIRE(connect(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
    }
    ~Stream() { close(fd_); }
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;

    void send(const std::string& bytes) const {
        [[maybe_unused]] const ssize_t sent = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    }
    /// Reads until the other side closes the stream.
    std::string read_all() const {
        std::string all;
        std::array<char, 4096> bytes{};
        pollfd entry{fd_, POLLIN, 0};
        while (poll(&entry, 1, stream_patience_ms) > 0) {
            const ssize_t count = read(fd_, bytes.data(), bytes.size());
            if (count <= 0) {
                break;
            }
            all.append(bytes.data(), static_cast<std::size_t>(count));
        }
        return all;
    }
    int fd() const { return fd_; }

  private:
    int fd_;
};

/// Passes one connection on to `port` and keeps what the client sends.
class RecordingProxy {
  public:
    explicit RecordingProxy(int port) : port_(port), listener_(socket(AF_INET, SOCK_STREAM, 0)) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        REQUIRE(bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
        REQUIRE(listen(listener_, 1) == 0);
        socklen_t size = sizeof address;
        getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
        own_port_ = ntohs(address.sin_port);
        thread_ = std::thread([this] { pass_on(); });
    }
    ~RecordingProxy() { close(listener_); }
    RecordingProxy(const RecordingProxy&) = delete;
    RecordingProxy& operator=(const RecordingProxy&) = delete;
    int port() const { return own_port_; }
    /// Returns the bytes of the client. Its connection must have ended.
    std::string take() {
        thread_.join();
        return recorded_;
    }

  private:
    void pass_on() {
        const int client = accept(listener_, nullptr, nullptr);
        const Stream server(port_);
        std::array<char, 4096> bytes{};
        for (bool open = true; open;) {
            std::array<pollfd, 2> ends = {pollfd{client, POLLIN, 0},
                                          pollfd{server.fd(), POLLIN, 0}};
            poll(ends.data(), ends.size(), stream_patience_ms);
            for (const bool from_client : {true, false}) {
                if (ends[from_client ? 0 : 1].revents == 0) {
                    continue;
                }
                const ssize_t count =
                    read(from_client ? client : server.fd(), bytes.data(), bytes.size());
                if (count <= 0) {
                    open = false;
                    break;
                }
                const std::string passed(bytes.data(), static_cast<std::size_t>(count));
                if (from_client) {
                    recorded_ += passed;
                    server.send(passed);
                } else {
                    [[maybe_unused]] const ssize_t sent =
                        ::send(client, passed.data(), passed.size(), MSG_NOSIGNAL);
                }
            }
        }
        close(client);
    }

    int port_, listener_, own_port_ = 0;
    std::string recorded_;
    std::thread thread_;
};

}  // namespace pxpl5::test
