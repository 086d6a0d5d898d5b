#include "ringbus/zmq/credentials.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/random.h>
#include <unistd.h>
#include <zmq.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string_view>

namespace pxpl5::bus {

namespace {

constexpr std::size_t key_length = 40;

/// The bytes in the pipe.
struct Packed {
    std::uint64_t low = 0, high = 0;
    std::uint8_t has_keys = 0, allows_plain_tcp = 0, allows_network = 0;
    std::array<char, key_length> open{}, secret{};
};

void set_secret(Credentials& credentials) {
    std::array<std::uint64_t, 2> bits{};
    if (getrandom(bits.data(), sizeof bits, 0) != static_cast<ssize_t>(sizeof bits)) {
        throw std::runtime_error(
            fmt::format("cannot make the secret of a machine: the system "
                        "gives no random numbers: {}",
                        std::strerror(errno)));
    }
    credentials.secret = schema::Secret(bits[0], bits[1]);
}

}  // namespace

bool has_curve() {
    return zmq_has("curve") != 0;
}

bool is_pair(const CurveKeys& keys) {
    std::array<char, key_length + 1> open{};
    return keys.open.size() == key_length && keys.secret.size() == key_length &&
           zmq_curve_public(open.data(), keys.secret.c_str()) == 0 && keys.open == open.data();
}

Credentials make_credentials(Protection protection, Reach reach) {
    Credentials credentials;
    set_secret(credentials);
    credentials.allows_plain_tcp = protection == Protection::plain_tcp;
    credentials.allows_network = reach == Reach::network;
    if (protection == Protection::curve) {
        std::array<char, key_length + 1> open{}, secret{};
        if (zmq_curve_keypair(open.data(), secret.data()) != 0) {
            throw std::runtime_error(
                fmt::format("cannot make a key pair: {}", zmq_strerror(zmq_errno())));
        }
        credentials.keys = CurveKeys{open.data(), secret.data()};
    }
    return credentials;
}

int credentials_pipe(const Credentials& credentials) {
    Packed packed;
    packed.low = credentials.secret.low();
    packed.high = credentials.secret.high();
    packed.allows_plain_tcp = credentials.allows_plain_tcp ? 1 : 0;
    packed.allows_network = credentials.allows_network ? 1 : 0;
    if (credentials.keys) {
        packed.has_keys = 1;
        std::memcpy(packed.open.data(), credentials.keys->open.data(), key_length);
        std::memcpy(packed.secret.data(), credentials.keys->secret.data(), key_length);
    }
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) {
        throw std::runtime_error(
            fmt::format("cannot hand credentials to a child: {}", std::strerror(errno)));
    }
    const ssize_t written = write(ends[1], &packed, sizeof packed);  // Fits into the pipe.
    close(ends[1]);
    if (written != static_cast<ssize_t>(sizeof packed)) {
        close(ends[0]);
        throw std::runtime_error("cannot hand credentials to a child: the pipe is full");
    }
    return ends[0];
}

Credentials inherit_credentials(int descriptor) {
    Packed packed;
    const ssize_t bytes = read(descriptor, &packed, sizeof packed);
    close(descriptor);
    if (bytes != static_cast<ssize_t>(sizeof packed)) {
        throw std::runtime_error(fmt::format(
            "descriptor {} has no credentials ({} bytes, expected {}); pxpl5 starts this program "
            "itself",
            descriptor, bytes, sizeof packed));
    }
    Credentials credentials;
    credentials.secret = schema::Secret(packed.low, packed.high);
    credentials.allows_plain_tcp = packed.allows_plain_tcp != 0;
    credentials.allows_network = packed.allows_network != 0;
    if (packed.has_keys != 0) {
        credentials.keys = CurveKeys{std::string(packed.open.data(), key_length),
                                     std::string(packed.secret.data(), key_length)};
    }
    return credentials;
}

}  // namespace pxpl5::bus
