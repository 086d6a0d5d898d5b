#include "ringbus/zmq/inbound.hpp"

#include <fmt/core.h>
#include <sys/epoll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "ringbus/zmq/zmq_parts.hpp"

namespace pxpl5::bus {

namespace {

void watch(int set, const zmq::socket_t& socket) {
    epoll_event event{};
    event.events = EPOLLIN;
    if (set < 0 || epoll_ctl(set, EPOLL_CTL_ADD, socket.get(zmq::sockopt::fd), &event) != 0) {
        throw std::runtime_error(
            fmt::format("cannot wait for two sockets: {}", std::strerror(errno)));
    }
}

}  // namespace

Inbound::~Inbound() {
    if (both_ >= 0) {
        close(both_);
    }
}

zmq::socket_t& Inbound::open_apart() {
    zmq::socket_t& apart = apart_.emplace(context_, zmq::socket_type::pull);
    both_ = epoll_create1(EPOLL_CLOEXEC);
    watch(both_, common_);
    watch(both_, apart);
    return apart;
}

std::string Inbound::bind(Entrance entrance, const std::string& address) {
    try {
        uninterrupted([&] { socket(entrance).bind(address); });
    } catch (const zmq::error_t& error) {
        throw std::runtime_error(fmt::format("cannot listen at {}: {}", address, error.what()));
    }
    return socket(entrance).get(zmq::sockopt::last_endpoint);
}

bool Inbound::take_from(Entrance entrance, zmq::message_t& head) {
    return (entrance == Entrance::common || apart_) && uninterrupted([&] {
               return socket(entrance).recv(head, zmq::recv_flags::dontwait).has_value();
           });
}

std::optional<Entrance> Inbound::take(zmq::message_t& head) {
    std::array turns = {Entrance::common, Entrance::apart};
    if (is_apart_first_) {
        std::swap(turns[0], turns[1]);
    }
    for (const Entrance entrance : turns) {
        if (take_from(entrance, head)) {
            return entrance;
        }
    }
    is_apart_first_ = false;
    return std::nullopt;
}

int Inbound::poll_fd() const {
    return apart_ ? both_ : static_cast<int>(common_.get(zmq::sockopt::fd));
}

bool Inbound::wait(int timeout_ms) {
    std::array<zmq::pollitem_t, 2> items{};
    items[0] = {common_.handle(), 0, ZMQ_POLLIN, 0};
    items[1] = {apart_ ? apart_->handle() : nullptr, 0, ZMQ_POLLIN, 0};
    try {
        return zmq::poll(items.data(), apart_ ? 2 : 1, std::chrono::milliseconds(timeout_ms)) > 0;
    } catch (const zmq::error_t& error) {
        if (error.num() == EINTR) {
            return false;
        }
        throw;
    }
}

}  // namespace pxpl5::bus
