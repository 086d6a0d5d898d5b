// An Ethernet switch in user space. Its cables delay, lose and limit frames.
//
// usage: wire SOCKET SEED    SOCKET is the number of an open, listening SOCK_SEQPACKET socket
//
// Each message is a request. The reply is "ok" or the error.
//   add NAME                    connects the TAP device that comes with the message
//   set NAME US US PPM MBIT     delay, jitter, loss and rate (0: no limit) of a cable, both ways
//   cut NAME, join NAME         drops all frames of a cable, silently; ends that
//
// A frame waits for its turn at the sender's rate, then for the delay and jitter of both cables,
// then for its turn at the receiver's rate. The frames from one computer to another keep their
// order. The same frames and the same seed give the same losses.
#include <fcntl.h>
#include <linux/if_tun.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <map>
#include <queue>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;
using Time = Clock::time_point;
using std::chrono::microseconds;
using std::chrono::nanoseconds;

constexpr std::size_t HEADER_BYTES = 10;  // struct virtio_net_hdr, which is before each frame.
constexpr std::size_t MAC_BYTES = 6;
constexpr std::size_t MAX_FRAME_BYTES = 70'000;
constexpr std::size_t MAX_WAITING_BYTES = std::size_t{1} << 28;
constexpr int MAX_FRAMES_AT_ONCE = 64;
constexpr microseconds MAX_QUEUE{200'000};  // At a rate; later frames are dropped.

struct Cable {
    std::string name;
    int tap = -1;
    bool is_cut = false;
    microseconds delay{0};
    microseconds jitter{0};
    std::uint32_t loss_ppm = 0;
    double rate_mbit = 0;
    Time sent_until{};                   // The rate is used up until then, from the computer.
    Time received_until{};               // The same, to the computer.
    std::map<std::size_t, Time> last{};  // When the last frame of each sender is due.
};

struct Frame {
    Time due;
    std::uint64_t number;
    std::size_t to;
    std::vector<char> data;
    bool operator<(const Frame& other) const {  // The first due is the greatest.
        return due != other.due ? due > other.due : number > other.number;
    }
};

class Switch {
  public:
    explicit Switch(std::uint64_t seed) : dice_(seed) {}

    /// Carries out a request. `tap` is a descriptor that came with it, or -1.
    std::string answer(const std::string& request, int tap);
    /// Delivers what is due. Returns how long until the next frame is due, at most 1 s.
    nanoseconds deliver();
    /// Reads frames that a computer has sent.
    void read_from(std::size_t index);
    /// Forgets the TAP device of a cable. The computer is gone.
    void disconnect(std::size_t index);
    [[nodiscard]] const std::vector<Cable>& cables() const { return cables_; }

  private:
    void connect(const std::string& name, int tap);
    void set_offloads() const;
    void forward(std::size_t from, std::size_t to, const char* data, std::size_t bytes);
    bool is_lost(const Cable& cable);

    std::vector<Cable> cables_;
    std::map<std::uint64_t, std::size_t> cable_of_;  // By MAC address.
    std::priority_queue<Frame> waiting_;
    std::size_t waiting_bytes_ = 0;
    std::uint64_t count_ = 0;
    std::mt19937_64 dice_;
};

std::uint64_t mac_at(const char* bytes) {
    std::uint64_t mac = 0;
    std::memcpy(&mac, bytes, MAC_BYTES);
    return mac;
}

/// When a frame that may leave at `start` has passed at this rate.
Time passed(Time& used_until, double rate_mbit, Time start, std::size_t bytes) {
    if (rate_mbit <= 0) {
        return start;
    }
    const auto ns = static_cast<std::int64_t>(static_cast<double>(bytes) * 8000.0 / rate_mbit);
    used_until = std::max(used_until, start) + nanoseconds(ns);
    return used_until;
}

void Switch::connect(const std::string& name, int tap) {
    Cable cable;
    cable.name = name;
    cable.tap = tap;
    const auto is_old = [&](const Cable& other) { return other.name == name; };
    const auto found = std::find_if(cables_.begin(), cables_.end(), is_old);
    if (found == cables_.end()) {
        cables_.push_back(cable);
    } else {
        close(found->tap);  // Of a computer that has lost its power.
        *found = cable;
    }
    set_offloads();
}

/// Frames of up to 64 KiB are faster, but a loss takes frames of the usual size.
void Switch::set_offloads() const {
    const bool has_loss = std::any_of(cables_.begin(), cables_.end(),
                                      [](const Cable& cable) { return cable.loss_ppm > 0; });
    const unsigned flags = TUN_F_CSUM | (has_loss ? 0U : TUN_F_TSO4 | TUN_F_TSO6);
    for (const Cable& cable : cables_) {
        ioctl(cable.tap, TUNSETOFFLOAD, flags);
    }
}

std::string Switch::answer(const std::string& request, int tap) {
    std::istringstream words(request);
    std::string verb;
    std::string name;
    words >> verb >> name;
    if (verb == "add" && tap >= 0) {
        connect(name, tap);
        return "ok";
    }
    const auto found = std::find_if(cables_.begin(), cables_.end(),
                                    [&](const Cable& cable) { return cable.name == name; });
    if (found == cables_.end()) {
        return "no cable is called " + name;
    }
    if (verb == "cut" || verb == "join") {
        found->is_cut = verb == "cut";
        return "ok";
    }
    std::int64_t delay_us = 0;
    std::int64_t jitter_us = 0;
    words >> delay_us >> jitter_us >> found->loss_ppm >> found->rate_mbit;
    if (verb != "set" || !words) {
        return "not a request: " + request;
    }
    found->delay = microseconds(delay_us);
    found->jitter = microseconds(jitter_us);
    found->sent_until = found->received_until = {};
    set_offloads();
    return "ok";
}

bool Switch::is_lost(const Cable& cable) {
    constexpr std::uint32_t MILLION = 1'000'000;
    return cable.is_cut || (cable.loss_ppm > 0 && dice_() % MILLION < cable.loss_ppm);
}

void Switch::forward(std::size_t from, std::size_t to, const char* data, std::size_t bytes) {
    Cable& sender = cables_[from];
    Cable& receiver = cables_[to];
    if (is_lost(sender) || is_lost(receiver) || waiting_bytes_ > MAX_WAITING_BYTES) {
        return;
    }
    const Time now = Clock::now();
    if (sender.sent_until - now > MAX_QUEUE ||
        receiver.received_until - now > MAX_QUEUE + sender.delay + receiver.delay) {
        return;
    }
    Time due = passed(sender.sent_until, sender.rate_mbit, now, bytes);
    due += sender.delay + receiver.delay;
    if (const auto jitter = sender.jitter + receiver.jitter; jitter.count() > 0) {
        due += microseconds(dice_() % static_cast<std::uint64_t>(jitter.count() + 1));
    }
    due = std::max(due, receiver.last[from]);
    due = passed(receiver.received_until, receiver.rate_mbit, due, bytes);
    receiver.last[from] = due;
    waiting_bytes_ += bytes;
    waiting_.push({due, count_++, to, {data, data + bytes}});
}

void Switch::read_from(std::size_t index) {
    std::array<char, MAX_FRAME_BYTES> buffer{};
    for (int i = 0; i < MAX_FRAMES_AT_ONCE; ++i) {
        const ssize_t size = read(cables_[index].tap, buffer.data(), buffer.size());
        if (size == 0) {
            disconnect(index);
        }
        if (size < static_cast<ssize_t>(HEADER_BYTES + 2 * MAC_BYTES)) {
            return;
        }
        const char* const frame = buffer.data() + HEADER_BYTES;
        const auto bytes = static_cast<std::size_t>(size);
        cable_of_[mac_at(frame + MAC_BYTES)] = index;
        const auto found = cable_of_.find(mac_at(frame));
        const bool is_for_all = (frame[0] & 1) != 0 || found == cable_of_.end();
        for (std::size_t to = 0; to < cables_.size(); ++to) {
            if (to != index && (is_for_all || to == found->second)) {
                forward(index, to, buffer.data(), bytes);
            }
        }
    }
}

void Switch::disconnect(std::size_t index) {
    close(cables_[index].tap);
    cables_[index].tap = -1;
}

nanoseconds Switch::deliver() {
    constexpr nanoseconds MAX_WAIT = std::chrono::seconds(1);
    while (!waiting_.empty()) {
        const Frame& frame = waiting_.top();
        const nanoseconds left = frame.due - Clock::now();
        if (left.count() > 0) {
            return std::min(left, MAX_WAIT);
        }
        const Cable& cable = cables_[frame.to];
        if (!cable.is_cut) {
            // A computer that does not take the frame has lost it.
            [[maybe_unused]] const ssize_t size =
                write(cable.tap, frame.data.data(), frame.data.size());
        }
        waiting_bytes_ -= frame.data.size();
        waiting_.pop();
    }
    return MAX_WAIT;
}

/// Answers one request. Returns false if the peer has closed the connection.
bool serve(int peer, Switch& hub) {
    std::array<char, 256> text{};
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> extra{};
    iovec part{text.data(), text.size()};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = extra.data();
    message.msg_controllen = extra.size();
    const ssize_t size = recvmsg(peer, &message, MSG_CMSG_CLOEXEC);
    if (size <= 0) {
        return false;
    }
    int tap = -1;
    if (const cmsghdr* const header = CMSG_FIRSTHDR(&message);
        header != nullptr && header->cmsg_type == SCM_RIGHTS) {
        std::memcpy(&tap, CMSG_DATA(header), sizeof tap);
    }
    const std::string reply = hub.answer({text.data(), static_cast<std::size_t>(size)}, tap);
    return send(peer, reply.data(), reply.size(), MSG_NOSIGNAL) >= 0;
}

void run(int listening, Switch& hub) {
    std::vector<int> peers;
    for (;;) {
        const nanoseconds left = hub.deliver();
        const timespec limit{left.count() / 1'000'000'000, left.count() % 1'000'000'000};
        std::vector<pollfd> ready{{listening, POLLIN, 0}};
        for (const int peer : peers) {
            ready.push_back({peer, POLLIN, 0});
        }
        for (const Cable& cable : hub.cables()) {
            ready.push_back({cable.tap, POLLIN, 0});
        }
        ppoll(ready.data(), ready.size(), &limit, nullptr);
        const std::size_t first_cable = 1 + peers.size();
        for (std::size_t i = first_cable; i < ready.size(); ++i) {
            if ((ready[i].revents & POLLIN) != 0) {
                hub.read_from(i - first_cable);
            } else if (ready[i].revents != 0) {
                hub.disconnect(i - first_cable);
            }
        }
        for (std::size_t i = first_cable - 1; i > 0; --i) {
            if (ready[i].revents != 0 && !serve(ready[i].fd, hub)) {
                close(ready[i].fd);
                peers.erase(peers.begin() + static_cast<std::ptrdiff_t>(i - 1));
            }
        }
        if (ready[0].revents != 0) {
            peers.push_back(accept4(listening, nullptr, nullptr, SOCK_CLOEXEC));
        }
    }
}

}  // namespace

int main(int count, char** words) {
    if (count != 3) {
        return 64;
    }
    Switch hub(std::strtoull(words[2], nullptr, 10));
    run(static_cast<int>(std::strtol(words[1], nullptr, 10)), hub);
}
