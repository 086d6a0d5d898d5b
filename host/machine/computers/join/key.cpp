#include "host/machine/computers/join/key.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <sstream>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/kernel/owned_descriptor.hpp"
#include "host/base/kernel/run_program.hpp"
#include "host/machine/processes/supervisor.hpp"

namespace pxpl5::host {

namespace {

constexpr std::string_view mark = "pxpl5-key-1";
constexpr std::string_view no_key = "-";
constexpr std::size_t key_length = 40;
constexpr std::size_t max_key_bytes = 4096;
constexpr int munge_ms = 10'000;
constexpr int hexadecimal = 16;
constexpr std::size_t number_digits = 16;  // Of 64 bits.

void write_all(int fd, std::string_view text) {
    if (write(fd, text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
        throw RequestError(ExitCode::failed,
                           fmt::format("cannot write the key: {}", std::strerror(errno)));
    }
}

std::string read_all(int fd) {
    std::string text(max_key_bytes, '\0');
    const ssize_t got = pread(fd, text.data(), text.size(), 0);
    text.resize(static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
    return text;
}

/// Runs a program of munge with `input`. Returns its output. Throws RequestError with its last
/// words.
std::string run_munge(const std::vector<std::string>& words, std::string_view input) {
    const ProgramEnd end = run_program(words, input, munge_ms);
    if (end.code != 0) {
        throw RequestError(
            ExitCode::unavailable,
            fmt::format("{} {}: {}", words[0], end.is_in_time ? "failed" : "did not end in time",
                        end.errors.substr(0, end.errors.find('\n'))));
    }
    return end.out;
}

void require_curve() {
    if (!bus::has_curve()) {
        throw RequestError(ExitCode::unavailable,
                           "this computer's libzmq has no CURVE, so there can be no key. Install a "
                           "libzmq with libsodium");
    }
}

}  // namespace

bus::Credentials make_key() {
    require_curve();
    return bus::make_credentials(bus::Protection::curve, bus::Reach::network);
}

bus::Credentials machine_key(const ClusterSettings& cluster, bus::Protection protection) {
    if (cluster.key_file.empty()) {
        return bus::make_credentials(
            protection, cluster.is_used() ? bus::Reach::network : bus::Reach::this_computer);
    }
    if (cluster.engine != Engine::wait || protection != bus::Protection::curve) {
        throw RequestError(
            ExitCode::usage,
            fmt::format("--key-file {}: a key of your own is for --engine wait without "
                        "--insecure-tcp; the engine is {}",
                        cluster.key_file, enum_name(cluster.engine)));
    }
    bus::Credentials key = read_key_file(cluster.key_file);
    if (!key.keys || key.allows_plain_tcp || !key.allows_network) {
        throw RequestError(ExitCode::usage,
                           fmt::format("the key file {} has a key of a machine without encryption. "
                                       "Make another one with: pxpl5 key",
                                       cluster.key_file));
    }
    return key;
}

std::string key_text(const bus::Credentials& credentials) {
    return fmt::format("{} {}{} {:016x}{:016x} {} {}\n", mark, credentials.allows_plain_tcp ? 1 : 0,
                       credentials.allows_network ? 1 : 0, credentials.secret.low(),
                       credentials.secret.high(),
                       credentials.keys ? credentials.keys->open : no_key,
                       credentials.keys ? credentials.keys->secret : no_key);
}

bus::Credentials parse_key(std::string_view text, const std::string& source) {
    std::istringstream stream{std::string(text)};
    std::string begin, flags, bits, open, secret;
    stream >> begin >> flags >> bits >> open >> secret;
    std::array<std::uint64_t, 2> numbers{};
    const bool has_keys = open.size() == key_length && secret.size() == key_length;
    bool is_sound = begin == mark && flags.size() == 2 && bits.size() == 2 * number_digits &&
                    (has_keys || (open == no_key && secret == no_key));
    for (std::size_t i = 0; is_sound && i < numbers.size(); ++i) {
        const char* first = bits.data() + i * number_digits;
        const auto [end, error] =
            std::from_chars(first, first + number_digits, numbers[i], hexadecimal);
        is_sound = error == std::errc{} && end == first + number_digits;
    }
    if (!is_sound) {
        throw RequestError(ExitCode::usage,
                           fmt::format("{} has no key of a pxpl5 machine ({} bytes, beginning "
                                       "with '{}', expected '{}')",
                                       source, text.size(), begin.substr(0, mark.size()), mark));
    }
    bus::Credentials credentials;
    credentials.secret = bus::schema::Secret(numbers[0], numbers[1]);
    credentials.allows_plain_tcp = flags[0] == '1';
    credentials.allows_network = flags[1] == '1';
    if (has_keys) {
        require_curve();
        credentials.keys = bus::CurveKeys{open, secret};
    }
    if (has_keys && !bus::is_pair(*credentials.keys)) {
        throw RequestError(
            ExitCode::usage,
            fmt::format("{} has a damaged key: its two parts of {} characters are no pair. Copy "
                        "the file again, or make another key with: pxpl5 key",
                        source, key_length));
    }
    return credentials;
}

void write_key_file(const std::filesystem::path& path, const bus::Credentials& credentials) {
    const OwnedDescriptor file(open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
    if (file.fd < 0) {
        throw RequestError(ExitCode::failed, fmt::format("cannot make the key file {}: {}",
                                                         path.string(), std::strerror(errno)));
    }
    try {
        write_all(file.fd, key_text(credentials));
    } catch (const RequestError&) {
        unlink(path.c_str());  // A part of a key would be in the way of the next one.
        throw;
    }
}

namespace {

/// True if users whom the owner has not chosen may read or write the file.
bool is_open_to_others(const struct stat& facts) {
    constexpr mode_t all = 07777U, others = S_IRWXG | S_IRWXO, of_secret = S_IRUSR | S_IRGRP;
    // Kubernetes mounts a Secret like this for a user who is not root: it belongs to root, and the
    // group of the pod (fsGroup) may read it.
    const bool is_secret = facts.st_uid == 0 && (facts.st_mode & all) == of_secret;
    return !is_secret && (facts.st_mode & others) != 0;
}

}  // namespace

bus::Credentials read_key_file(const std::filesystem::path& path) {
    const OwnedDescriptor file(open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
    struct stat facts {};
    if (file.fd < 0 || fstat(file.fd, &facts) != 0) {
        throw RequestError(ExitCode::usage, fmt::format("cannot read the key file {}: {}",
                                                        path.string(), std::strerror(errno)));
    }
    if (!S_ISREG(facts.st_mode)) {
        throw RequestError(ExitCode::usage,
                           fmt::format("the key file {} is a folder, a device or a FIFO: give a "
                                       "file that 'pxpl5 key' has made",
                                       path.string()));
    }
    if (is_open_to_others(facts)) {
        throw RequestError(
            ExitCode::usage,
            fmt::format("the key file {} has mode {:04o}, so others may read it. Run: chmod 600 {}",
                        path.string(), facts.st_mode & 07777U, path.string()));
    }
    if (facts.st_uid != 0 && facts.st_uid != geteuid()) {
        throw RequestError(
            ExitCode::usage,
            fmt::format("the key file {} belongs to user {}, who knows the key; this program runs "
                        "as user {}. Use a key file of your own",
                        path.string(), facts.st_uid, geteuid()));
    }
    return parse_key(read_all(file.fd), "the key file " + path.string());
}

bus::Credentials read_key_from_input(int limit_ms) {
    const std::int64_t end_ms = now_ms() + limit_ms;
    std::string text;
    while (text.find('\n') == std::string::npos) {
        pollfd input{STDIN_FILENO, POLLIN, 0};
        const std::int64_t left_ms = std::max<std::int64_t>(end_ms - now_ms(), 0);
        char byte = 0;
        const int ready = poll(&input, 1, static_cast<int>(left_ms));
        if (ready < 0 && errno == EINTR) {
            continue;
        }
        if (ready <= 0) {
            throw RequestError(
                ExitCode::unavailable,
                fmt::format("no key came at standard input within {} s", limit_ms / 1000));
        }
        if (read(STDIN_FILENO, &byte, 1) != 1 || text.size() == max_key_bytes) {
            throw RequestError(
                ExitCode::usage,
                fmt::format("standard input ended after {} bytes without a key", text.size()));
        }
        text.push_back(byte);
    }
    return parse_key(text, "standard input");
}

std::string munge_credential(const bus::Credentials& credentials) {
    // --ttl -1: as long as munged allows, because a job may wait in a queue.
    std::string credential = run_munge({"munge", "--uid", std::to_string(getuid()), "--ttl", "-1"},
                                       key_text(credentials));
    while (!credential.empty() && credential.back() == '\n') {
        credential.pop_back();
    }
    return credential;
}

bus::Credentials open_munge_credential(const std::string& credential) {
    const std::string text = run_munge({"unmunge", "--metadata", "/dev/null"}, credential + "\n");
    return parse_key(text, "the munge credential");
}

}  // namespace pxpl5::host
