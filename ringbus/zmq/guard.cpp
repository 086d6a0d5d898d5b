#include "ringbus/zmq/guard.hpp"

#include <pthread.h>

#include <array>
#include <csignal>
#include <cstring>
#include <map>
#include <utility>
#include <vector>

#include "ringbus/zmq/zmq_parts.hpp"

namespace pxpl5::bus {

namespace {

constexpr const char* zap_address = "inproc://zeromq.zap.01";
constexpr const char* events_address = "inproc://pxpl5-events";
constexpr const char* followed_address = "inproc://pxpl5-followed-events";
constexpr std::size_t key_bytes = 32;

std::vector<zmq::message_t> receive_all(zmq::socket_t& socket) {
    std::vector<zmq::message_t> parts;
    do {
        parts.emplace_back();
        static_cast<void>(
            uninterrupted([&] { return socket.recv(parts.back(), zmq::recv_flags::none); }));
    } while (parts.back().more());
    return parts;
}

/// True if the question (ZeroMQ RFC 27) is about a client with this public key.
bool is_ours(const std::vector<zmq::message_t>& question,
             const std::array<std::uint8_t, key_bytes>& key) {
    constexpr std::size_t mechanism = 5, credentials = 6, parts = 7;
    return question.size() == parts && question[mechanism].to_string_view() == "CURVE" &&
           question[credentials].size() == key_bytes &&
           std::memcmp(question[credentials].data(), key.data(), key_bytes) == 0;
}

void answer(zmq::socket_t& zap, const std::array<std::uint8_t, key_bytes>& key) {
    const std::vector<zmq::message_t> question = receive_all(zap);
    const bool ours = is_ours(question, key);
    const std::string request = question.size() > 1 ? question[1].to_string() : "";
    const std::array<std::string, 6> parts = {"1.0", request, ours ? "200" : "400", "", "", ""};
    for (std::size_t i = 0; i < parts.size(); ++i) {
        uninterrupted([&] {
            return zap.send(zmq::buffer(parts[i]), i + 1 < parts.size() ? zmq::send_flags::sndmore
                                                                        : zmq::send_flags::none);
        });
    }
}

/// Follows the connections of the inbound socket. ZeroMQ does not say which connection succeeded,
/// so a connection counts as a stranger's if ZeroMQ reports a failure before its end, or if none
/// has succeeded during its life.
class Connections {
  public:
    explicit Connections(Counted counted) : counts_cut_(counted == Counted::all) {}

    /// Returns whether a connection has ended that proved nothing.
    bool take(zmq::socket_t& events) {
        const std::vector<zmq::message_t> parts = receive_all(events);
        std::uint16_t event = 0;
        std::int32_t descriptor = 0;
        if (parts.front().size() < sizeof event + sizeof descriptor) {
            return false;
        }
        std::memcpy(&event, parts.front().data(), sizeof event);
        std::memcpy(&descriptor, parts.front().data<std::uint8_t>() + sizeof event,
                    sizeof descriptor);
        switch (event) {
            case ZMQ_EVENT_ACCEPTED:
                successes_before_[descriptor] = successes_;
                return false;
            case ZMQ_EVENT_HANDSHAKE_SUCCEEDED:
                ++successes_;
                return false;
            case ZMQ_EVENT_DISCONNECTED:
                return has_ended(descriptor);
            case ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL:
                (counts_cut_ ? has_failed_ : was_cut_) = true;
                return false;
            default:
                has_failed_ = true;
                return false;
        }
    }

  private:
    bool has_ended(std::int32_t descriptor) {
        const auto found = successes_before_.find(descriptor);
        const bool has_succeeded = found == successes_before_.end() || found->second != successes_;
        const bool has_failed = std::exchange(has_failed_, false);
        const bool was_cut = std::exchange(was_cut_, false);
        successes_before_.erase(descriptor);
        return has_failed || (!has_succeeded && !was_cut);
    }

    std::map<std::int32_t, std::uint64_t> successes_before_;  ///< By descriptor.
    std::uint64_t successes_ = 0;
    bool counts_cut_, has_failed_ = false, was_cut_ = false;
};

void guard_until_the_context_ends(zmq::socket_t zap, zmq::socket_t events,
                                  std::array<std::uint8_t, key_bytes> key, Counted counted,
                                  std::atomic<std::uint64_t>& strangers) {
    Connections connections(counted);
    std::array<zmq::pollitem_t, 2> items = {zmq::pollitem_t{zap.handle(), 0, ZMQ_POLLIN, 0},
                                            zmq::pollitem_t{events.handle(), 0, ZMQ_POLLIN, 0}};
    try {
        while (true) {
            uninterrupted([&] { return zmq::poll(items.data(), items.size()); });
            if ((items[0].revents & ZMQ_POLLIN) != 0) {
                answer(zap, key);
            }
            if ((items[1].revents & ZMQ_POLLIN) != 0 && connections.take(events)) {
                strangers.fetch_add(1, std::memory_order_relaxed);
            }
        }
    } catch (const zmq::error_t&) {
        // ETERM: the context ends.
    }
}

void follow_until_the_context_ends(zmq::socket_t events, std::atomic<std::uint64_t>& strangers) {
    Connections connections(Counted::all);
    try {
        while (true) {
            if (connections.take(events)) {
                strangers.fetch_add(1, std::memory_order_relaxed);
            }
        }
    } catch (const zmq::error_t&) {
        // ETERM: the context ends.
    }
}

/// A socket that receives what happens to the connections of `inbound`.
zmq::socket_t events_of(zmq::context_t& context, zmq::socket_t& inbound, const char* address) {
    constexpr int wanted = ZMQ_EVENT_ACCEPTED | ZMQ_EVENT_HANDSHAKE_SUCCEEDED |
                           ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL |
                           ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL | ZMQ_EVENT_HANDSHAKE_FAILED_AUTH;
    zmq::socket_t events(context, zmq::socket_type::pair);
    prepare(events);
    if (zmq_socket_monitor(inbound.handle(), address, wanted) != 0) {
        throw zmq::error_t();
    }
    events.connect(address);
    return events;
}

/// Starts a thread that gets no signals: these are for the thread that uses the link.
template <typename... Arguments>
std::thread thread_without_signals(Arguments&&... arguments) {
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    std::thread thread(std::forward<Arguments>(arguments)...);
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    return thread;
}

}  // namespace

void guard_inbound(zmq::socket_t& inbound, const CurveKeys& keys) {
    inbound.set(zmq::sockopt::curve_server, 1);
    inbound.set(zmq::sockopt::curve_secretkey, keys.secret);
    inbound.set(zmq::sockopt::zap_domain, "pxpl5");
}

void guard_outbound(zmq::socket_t& outbound, const CurveKeys& keys) {
    outbound.set(zmq::sockopt::curve_serverkey, keys.open);
    outbound.set(zmq::sockopt::curve_publickey, keys.open);
    outbound.set(zmq::sockopt::curve_secretkey, keys.secret);
}

void Guard::start(zmq::context_t& context, zmq::socket_t& inbound, const CurveKeys& keys,
                  Counted counted) {
    std::array<std::uint8_t, key_bytes> key{};
    if (zmq_z85_decode(key.data(), keys.open.c_str()) == nullptr) {
        throw std::runtime_error("the session's public key is damaged");
    }
    zmq::socket_t zap(context, zmq::socket_type::rep);
    prepare(zap);
    zap.bind(zap_address);
    thread_ = thread_without_signals(guard_until_the_context_ends, std::move(zap),
                                     events_of(context, inbound, events_address), key, counted,
                                     std::ref(strangers_));
}

void Guard::follow(zmq::context_t& context, zmq::socket_t& inbound) {
    follower_ =
        thread_without_signals(follow_until_the_context_ends,
                               events_of(context, inbound, followed_address), std::ref(strangers_));
}

Guard::~Guard() {
    for (std::thread* const thread : {&thread_, &follower_}) {
        if (thread->joinable()) {
            thread->join();
        }
    }
}

}  // namespace pxpl5::bus
