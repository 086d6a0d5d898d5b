#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <deque>
#include <filesystem>
#include <fstream>
#include <utility>

#include "ringbus/zmq/arena.hpp"
#include "tests/random_seed.hpp"
#include "tests/ringbus/ipc_address.hpp"
#include "tests/ringbus/large_bodies.hpp"

using namespace pxpl5;
using namespace pxpl5::bus;
using pxpl5::test::ipc_address;
using pxpl5::test::is_whole;
using pxpl5::test::large_slices;
using pxpl5::test::next_of;

namespace {

constexpr std::size_t body_bytes = 100'000;

using schema::Role;
/// Slices go from a host to a GP.
constexpr Self loader{1, Role::host}, taker{2, Role::gp};

const Credentials plain = [] {
    Credentials credentials;
    credentials.allows_plain_tcp = true;
    return credentials;
}();

Payload slices_from(ZmqLink& link, std::size_t bytes, std::uint32_t number) {
    return large_slices(link.body_allocator(), bytes, number);
}

std::ptrdiff_t count_of(const char* folder) {
    return std::distance(std::filesystem::directory_iterator(folder), {});
}

/// Shared memory that this process has mapped and touched, as the system reports it.
std::string shared_memory() {
    std::ifstream rollup("/proc/self/smaps_rollup");
    std::string line;
    while (std::getline(rollup, line) && !line.starts_with("Pss_Shmem:")) {
    }
    return line;
}

/// Runs `act` in a child process, which never returns.
template <typename Act>
pid_t run_apart(const Act& act) {
    const pid_t child = fork();
    if (child == 0) {
        act();
        while (true) {
            pause();
        }
    }
    return child;
}

void kill_and_bury(pid_t child) {
    kill(child, SIGKILL);
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
}

}  // namespace

TEST_SUITE("ringbus/shared_bodies") {
    TEST_CASE("a thousand bodies of any size arrive to the last byte, over ipc and over tcp") {
        const std::uint64_t seed = pxpl5::test::seed_or<std::uint64_t>(19'930'501);
        INFO("PXPL5_SEED=", seed);
        for (const char* tcp : {"", "tcp://127.0.0.1:*"}) {
            std::mt19937_64 random(seed);
            ZmqLink a(loader, *tcp != 0 ? tcp : ipc_address("random-a"), plain);
            ZmqLink b(taker, *tcp != 0 ? tcp : ipc_address("random-b"), plain);
            a.add_peer(2, Role::gp, b.endpoint());
            b.add_peer(1, Role::host, a.endpoint());
            std::deque<std::pair<Message, std::size_t>> kept;  // Some longer than others.
            for (std::uint32_t i = 0; i < 1000; ++i) {
                const std::size_t bytes = 1 + (random() >> (44 + random() % 20));
                a.send(2, slices_from(a, bytes, i));
                kept.emplace_back(next_of(b), bytes);
                CHECK(!a.receive());  // Takes the credit.
                REQUIRE(is_whole(kept.back().first, bytes, i));
                if (kept.size() > 20) {
                    kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(random() % 20));
                }
            }
            for (const auto& [message, bytes] : kept) {
                CHECK(is_whole(message, bytes, message.as<schema::Slices>()->first_slice()));
            }
        }
    }

    TEST_CASE("over ipc, bodies from the second on stay in the sender's memory until read") {
        ZmqLink a(loader, ipc_address("stay-a")), b(taker, ipc_address("stay-b"));
        a.add_peer(2, Role::gp, b.endpoint());
        b.add_peer(1, Role::host, a.endpoint());
        const std::uint8_t* first = nullptr;
        for (std::uint32_t i = 0; i < 3; ++i) {
            const Payload payload = slices_from(a, body_bytes, i);
            first = i == 0 ? nullptr : payload.bytes().data();
            a.send(2, payload);
            if (i < 2) {
                CHECK(is_whole(next_of(b), body_bytes, i));
            }
        }
        CHECK(slices_from(a, body_bytes, 9).bytes().data() != first);
        const std::optional<Message> message = next_of(b);
        CHECK(is_whole(*message, body_bytes, 2));
        CHECK(slices_from(a, body_bytes, 9).bytes().data() != first);
    }

    TEST_CASE("a sender whose arena is full sends inside the messages") {
        constexpr std::size_t lendable_bytes = std::size_t{244} << 10;  // Two bodies, not three.
        ZmqLink a(loader, ipc_address("full-a"), {}, lendable_bytes),
            b(taker, ipc_address("full-b"));
        a.add_peer(2, Role::gp, b.endpoint());
        b.add_peer(1, Role::host, a.endpoint());
        const Arena& arena = dynamic_cast<const Arena&>(*a.body_allocator());
        const auto exchange = [&](const Payload& payload) {
            a.send(2, payload);
            return next_of(b);
        };
        const Payload kept = slices_from(a, body_bytes, 0);
        exchange(kept);  // With the offer.
        Payload lent = slices_from(a, body_bytes, 1);
        CHECK(arena.can_lend(lent));
        std::optional<Message> borrowed = exchange(std::exchange(lent, {}));
        const Payload beyond = slices_from(a, body_bytes, 2);
        CHECK(!arena.can_lend(beyond));
        CHECK(is_whole(exchange(beyond), body_bytes, 2));
        CHECK(is_whole(*borrowed, body_bytes, 1));
        borrowed.reset();
        CHECK(arena.can_lend(slices_from(a, body_bytes, 3)));
    }

    TEST_CASE("bodies that a killed receiver had borrowed are free when its peer is removed") {
        const std::string to_child = ipc_address("killed-child"), to_us = ipc_address("killed-us");
        const pid_t child = run_apart([&] {
            static ZmqLink link(taker, to_child);
            link.add_peer(1, Role::host, to_us);
            static std::vector<Message> held;
            for (std::uint32_t i = 0; i < 2; ++i) {
                held.push_back(next_of(link));
                link.send(1, pack(schema::VolumeReadyT{}));
            }
        });
        ZmqLink link(loader, to_us);
        link.add_peer(2, Role::gp, to_child);
        std::vector<const std::uint8_t*> places;
        for (std::uint32_t i = 0; i < 2; ++i) {
            const Payload payload = slices_from(link, body_bytes, i);
            places.push_back(payload.bytes().data());
            link.send(2, payload);
            next_of(link);
        }
        CHECK(slices_from(link, body_bytes, 3).bytes().data() != places[1]);
        kill_and_bury(child);
        CHECK(slices_from(link, body_bytes, 3).bytes().data() != places[1]);
        link.remove_peer(2);
        CHECK(slices_from(link, body_bytes, 3).bytes().data() == places[1]);
    }

    TEST_CASE("messages of a killed sender can be read") {
        const std::string to_us = ipc_address("widow");
        const pid_t child = run_apart([&] {
            static ZmqLink link({2, Role::host}, ipc_address("dead-sender"));
            link.add_peer(1, Role::gp, to_us);
            for (std::uint32_t i = 0; i < 3; ++i) {
                link.send(1, slices_from(link, body_bytes, i));
                next_of(link);
            }
        });
        ZmqLink link({1, Role::gp}, to_us);
        link.add_peer(2, Role::host, ipc_address("dead-sender"));
        std::vector<Message> kept;
        for (std::uint32_t i = 0; i < 3; ++i) {
            kept.push_back(next_of(link));
            link.send(2, pack(schema::VolumeReadyT{}));
        }
        kill_and_bury(child);
        link.remove_peer(2);
        for (std::uint32_t i = 0; i < 3; ++i) {
            CHECK(is_whole(kept[i], body_bytes, i));
        }
    }

    TEST_CASE("no shared memory remains when links have ended") {
        const auto open_before = count_of("/proc/self/fd");
        const std::string shared_before = shared_memory();
        {
            ZmqLink a(loader, ipc_address("left-a")), b(taker, ipc_address("left-b"));
            a.add_peer(2, Role::gp, b.endpoint());
            b.add_peer(1, Role::host, a.endpoint());
            for (std::uint32_t i = 0; i < 3; ++i) {
                a.send(2, slices_from(a, body_bytes, i));
                next_of(b);
            }
            CHECK(count_of("/proc/self/fd") > open_before);
            CHECK(shared_memory() != shared_before);
        }
        CHECK(shared_memory() == shared_before);
        CHECK(count_of("/proc/self/fd") == open_before);
    }
}
