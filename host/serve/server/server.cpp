#include "host/serve/server/server.hpp"

#include <thread>

#include "host/base/kernel/signals_blocked.hpp"
#include "host/serve/server/server_loop.hpp"

namespace pxpl5::host::serve {
class Server::Core {
  public:
    explicit Core(const ServerOptions& options) : loop(options, mail) {
        mail.wake_server = [this] { loop.wake(); };
        const SignalsBlocked blocked;
        thread = std::thread([this] { loop.run(); });
    }
    ~Core() {
        loop.stop();
        thread.join();
    }
    Core(const Core&) = delete;
    Core& operator=(const Core&) = delete;

    Mail mail;
    Loop loop;
    std::thread thread;
};

Server::Server(const ServerOptions& options) : core_(std::make_unique<Core>(options)) {}
Server::~Server() = default;

std::string Server::url() const {
    return core_->loop.listener().address() +
           "?token=" + core_->loop.listener().rules().driver_token;
}
std::string Server::watch_url() const {
    return core_->loop.listener().address() +
           "?token=" + core_->loop.listener().rules().watcher_token;
}
int Server::port() const {
    return core_->loop.listener().port();
}

int Server::event_fd() const {
    return core_->mail.event_fd();
}
std::vector<Event> Server::take() {
    return core_->mail.take();
}

void Server::warn(EndsSoon soon) {
    core_->mail.push(std::move(soon));
}

void Server::send(std::uint32_t viewer, std::string text) {
    if (viewer == 0) {  // 0 would be all.
        return;
    }
    core_->mail.send({viewer, false, std::make_shared<const std::string>(std::move(text))});
}

void Server::broadcast(std::string text) {
    core_->mail.send({0, false, std::make_shared<const std::string>(std::move(text))});
}

void Server::send_binary(std::uint32_t viewer, std::string bytes) {
    if (viewer == 0) {
        return;
    }
    core_->mail.send({viewer, true, std::make_shared<const std::string>(std::move(bytes))});
}

void Server::opened(std::string path) {
    core_->mail.opened(std::move(path));
}
void Server::show(Shown frame) {
    core_->mail.show(std::move(frame));
}
void Server::wear(std::uint32_t viewer, std::size_t pair_pixels) {
    core_->mail.wear(viewer, pair_pixels);
}
bool Server::wants_frame() const {
    return core_->mail.wants_frame();
}
bool Server::wants_pair() const {
    return core_->mail.wants_pair();
}
LinkAdvice Server::advice() const {
    return core_->mail.advice();
}

}  // namespace pxpl5::host::serve
