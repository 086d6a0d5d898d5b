// Limits: messages for a receiver that takes nothing, and threads.
#include <doctest/doctest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <string>
#include <zmq.hpp>

#include "ringbus/credit.hpp"
#include "ringbus/node_loop.hpp"
#include "ringbus/wire.hpp"
#include "ringbus/zmq/zmq_link.hpp"
#include "tests/ringbus/ipc_address.hpp"

using namespace pxpl5;
using namespace pxpl5::bus;
using pxpl5::test::ipc_address;

namespace {

constexpr NodeId gp_id = 1;

/// A node whose work always fails, until it has failed `most` times.
struct Failing final : Node {
    std::uint32_t most = 0, failures = 0;

    explicit Failing(std::uint32_t limit) : most(limit) {}
    void receive(const Message&, Outbox&) override {}
    bool work(Outbox&) override {
        if (failures == most) {
            return false;
        }
        ++failures;
        throw NodeFault(schema::FaultCode::internal, "again");
    }
};

/// A host and a GP that know each other.
struct Machine {
    ZmqLink host{{host_id, schema::Role::host}, ipc_address("flooded-host")};
    ZmqLink gp{{gp_id, schema::Role::gp}, ipc_address("flooding-gp")};

    Machine() {
        host.add_peer(gp_id, schema::Role::gp, gp.endpoint());
        gp.add_peer(host_id, schema::Role::host, host.endpoint());
    }
};

/// Takes the messages that have arrived, and returns their number.
std::uint32_t take_all(ZmqLink& link) {
    std::uint32_t count = 0;
    while (link.receive()) {
        ++count;
    }
    return count;
}

}  // namespace

TEST_SUITE("ringbus/zmq/zmq_link_flood") {
    TEST_CASE("a node whose faults the host does not take does no more work") {
        Machine machine;
        Failing node(3 * window_messages);
        CHECK(!run_node(node, machine.gp, [] { return false; }));  // Ends when nothing comes.
        CHECK(node.failures == window_messages + 1);
        CHECK(machine.gp.queued() == 1);
        // The host takes them, and gets the rest.
        std::uint32_t taken = 0;
        const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
        while (taken < node.failures) {
            REQUIRE(std::chrono::steady_clock::now() < end);
            // Each waits for the other: the host for faults, the GP for credit.
            if (machine.host.wait(10)) {
                taken += take_all(machine.host);
            }
            if (machine.gp.wait(10)) {
                CHECK(!machine.gp.receive());  // Takes the credit.
            }
        }
        CHECK(machine.gp.queued() == 0);
    }

    TEST_CASE("a peer that sends without credit fills its own memory, and nothing is lost") {
        ZmqLink host({host_id, schema::Role::host}, ipc_address("unread"));
        host.add_peer(gp_id, schema::Role::gp, ipc_address("careless"));
        // The peer stores one message itself, so that it notices when the host reads no more.
        zmq::context_t context{1};
        zmq::socket_t careless{context, zmq::socket_type::push};
        careless.set(zmq::sockopt::linger, 0);
        careless.set(zmq::sockopt::sndhwm, 1);
        careless.set(zmq::sockopt::sndbuf, 4096);
        careless.connect(host.endpoint());
        const Payload body =
            fault_message(gp_id, host_id, 0, schema::FaultCode::internal, std::string(16384, 'x'));
        constexpr std::uint32_t many = 8 * max_unread_messages;
        constexpr int stalled_ms = 300;
        std::uint32_t sent = 0;
        for (zmq::pollitem_t item{careless.handle(), 0, ZMQ_POLLOUT, 0};
             sent < many && zmq::poll(&item, 1, std::chrono::milliseconds(stalled_ms)) > 0;
             ++sent) {
            const schema::Header header(header_magic, protocol_version,
                                        static_cast<std::uint16_t>(body.kind()), gp_id, host_id, 0,
                                        0, sent, body.bytes().size(), 0, 0, 1);
            careless.send(zmq::buffer(&header, sizeof header), zmq::send_flags::sndmore);
            careless.send(zmq::buffer(body.bytes().data(), body.bytes().size()));
        }
        CHECK(sent >= max_unread_messages);
        CHECK(sent < 2 * max_unread_messages);
        std::uint32_t taken = 0;
        while (taken < sent) {
            REQUIRE(host.wait(30'000));
            taken += take_all(host);
        }
        CHECK(taken == sent);
    }

    TEST_CASE("another user of the computer who may start one thread gets an error, no abort") {
        if (geteuid() != 0) {
            MESSAGE("skipped: only root can act as another user");
            return;
        }
        int out[2];
        REQUIRE(pipe(out) == 0);
        const pid_t child = fork();
        REQUIRE(child >= 0);
        if (child == 0) {
            constexpr uid_t lone_user = 64322;  // Has no other process.
            const rlimit two_threads{2, 2};
            if (setrlimit(RLIMIT_NPROC, &two_threads) != 0 || setgid(lone_user) != 0 ||
                setuid(lone_user) != 0) {
                _exit(2);
            }
            try {
                const ZmqLink link({gp_id, schema::Role::gp}, "ipc:///tmp/pxpl5-not-reached");
            } catch (const std::runtime_error& error) {
                const std::string text = error.what();
                _exit(write(out[1], text.data(), text.size()) > 0 ? 0 : 3);
            }
            _exit(1);
        }
        close(out[1]);
        std::string text(1024, '\0');
        text.resize(
            static_cast<std::size_t>(std::max<ssize_t>(0, read(out[0], text.data(), text.size()))));
        close(out[0]);
        int status = 0;
        REQUIRE(waitpid(child, &status, 0) == child);
        CHECK(status == 0);
        CHECK_MESSAGE(text.starts_with("cannot start thread 2 of the 2 that ZeroMQ needs: "), text);
    }
}
