// A node that does nothing, or misbehaves on request: what the launcher's tests launch.
//
// MISBEHAVE in the environment: "build" says Hello with another build, "silent" never says Hello,
// "deaf" ignores Shutdown and SIGTERM, "secret" says Hello first without the secret, then with it.
// RemoveSurface{n} and ReadMesh{"n"} are orders, see Order.
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>

#include "host/io/sandbox/system_calls.hpp"
#include "ringbus/process/process.hpp"
#include "ringbus/zmq/zmq_link.hpp"
#include "tests/host/machine/idle_node.hpp"

namespace {

using namespace pxpl5;
namespace schema = bus::schema;
constexpr auto role = static_cast<schema::Role>(PXPL5_ROLE);

void stay_for_ever() {
    for (;;) {
        pause();
    }
}

/// A process that a file has taken over can write any header on its connection to the host.
void write_in_the_name_of_gp_0(const bus::ProcessFlags& flags) {
    constexpr bus::NodeId gp_0 = 1;
    bus::Credentials credentials;
    credentials.allows_plain_tcp = true;
    const bool is_ipc = flags.bind.starts_with("ipc:");
    bus::ZmqLink forger({gp_0, schema::Role::gp}, flags.bind + (is_ipc ? "-forger" : ""),
                        credentials);
    forger.add_peer(bus::host_id, schema::Role::host, flags.host_endpoint);
    forger.send(bus::host_id, bus::pack(schema::VolumeReadyT{}));
    forger.linger(bus::host_id, -1);
}

class IdleNode final : public bus::Node {
  public:
    explicit IdleNode(bus::ProcessFlags flags) : flags_(std::move(flags)) {}

    void receive(const bus::Message& message, bus::Outbox& out) override {
        if (const auto* order = message.as<schema::RemoveSurface>()) {
            obey(static_cast<test::Order>(order->surface()), out);
        } else if (const auto* io_order = message.as<schema::ReadMesh>()) {
            obey(static_cast<test::Order>(std::stoi(io_order->path()->str())), out);
        }
    }
    bool work(bus::Outbox&) override { return false; }

  private:
    void obey(test::Order order, bus::Outbox& out) const {
        switch (order) {
            case test::Order::forge:
                write_in_the_name_of_gp_0(flags_);
                [[fallthrough]];
            case test::Order::answer:
                answer(out);
                return;
            case test::Order::forbidden:
                out.send(bus::host_id, bus::pack(schema::FrameDoneT{}));
                return;
            case test::Order::damaged:
                out.send(bus::host_id, damaged());
                return;
            case test::Order::chatter:
                for (int i = 0; i < test::chatter_messages; ++i) {
                    answer(out);
                }
                return;
            case test::Order::fault:
                throw bus::NodeFault(schema::FaultCode::bad_input, "as ordered");
            case test::Order::exit_70:
                std::fputs("error: as ordered\n", stderr);
                std::exit(70);
            case test::Order::leave:
                std::exit(0);
            case test::Order::abort:
                std::abort();
            case test::Order::hang:
                stay_for_ever();
                return;
            case test::Order::start:
                host::io::restrict_system_calls(host::io::Task::read);
                execl("/bin/true", "true", nullptr);
                return;
        }
    }

    static void answer(bus::Outbox& out) {
        out.send(bus::host_id, role == schema::Role::io ? bus::pack(schema::IoDoneT{})
                                                        : bus::pack(schema::VolumeReadyT{}));
    }

    static bus::Payload damaged() {
        if (role == schema::Role::io) {
            schema::VolumeHeaderT header;
            header.voxel_to_patient = std::make_unique<schema::Matrix>();
            return bus::pack(header);  // Without a voxel.
        }
        schema::SurfaceBuiltT built;
        built.slabs.emplace_back();
        built.slabs.back().mutate_slab(~0U);
        return bus::pack(built);
    }

    bus::ProcessFlags flags_;
};

void say_hello_as_another_build(int argc, char** argv) {
    const bus::ProcessFlags flags = bus::parse_flags(argc, argv);
    const bus::Credentials credentials = bus::inherit_credentials(flags.credentials_fd);
    bus::ZmqLink link({flags.node_id, role}, flags.bind, credentials);
    link.add_peer(bus::host_id, schema::Role::host, flags.host_endpoint);
    schema::HelloT hello;
    hello.secret = std::make_unique<schema::Secret>(credentials.secret);
    hello.role = role;
    hello.index = flags.index;
    hello.pid = static_cast<std::uint32_t>(getpid());
    hello.endpoint = link.endpoint();
    hello.build = "another build";
    hello.schema_hash = bus::schema_hash();
    link.send(bus::host_id, bus::pack(hello));
    stay_for_ever();
}

/// A Hello of this node's number from another process, which has not inherited the secret.
void say_hello_without_the_secret(int argc, char** argv) {
    const bus::ProcessFlags flags = bus::parse_flags(argc, argv);
    bus::ZmqLink stranger({flags.node_id, role}, flags.bind + "-stranger");
    stranger.add_peer(bus::host_id, schema::Role::host, flags.host_endpoint);
    schema::HelloT hello;
    hello.role = role;
    hello.index = flags.index;
    hello.pid = static_cast<std::uint32_t>(getpid());
    hello.endpoint = stranger.endpoint();
    hello.build = bus::build_id();
    hello.schema_hash = bus::schema_hash();
    for (const std::uint64_t guess : {0ULL, 1ULL}) {
        hello.secret = std::make_unique<schema::Secret>(guess, guess);
        stranger.send(bus::host_id, bus::pack(hello));
    }
    hello.secret.reset();
    stranger.send(bus::host_id, bus::pack(hello));
    stranger.linger(bus::host_id, -1);  // The host has them before the true Hello leaves.
}

}  // namespace

int main(int argc, char** argv) {
    const char* named = std::getenv("PXPL5_MISBEHAVE");  // The name that a topology file may set.
    const char* how = named != nullptr ? named : std::getenv("MISBEHAVE");
    const std::string misbehave = how == nullptr ? "" : how;
    if (misbehave == "build") {
        say_hello_as_another_build(argc, argv);
    } else if (misbehave == "silent") {
        stay_for_ever();
    } else if (misbehave == "secret") {
        say_hello_without_the_secret(argc, argv);
    } else if (misbehave == "deaf") {
        std::signal(SIGTERM, SIG_IGN);
        std::atexit(stay_for_ever);
    }
    return bus::run_process(
        argc, argv, role, [&] { return std::make_unique<IdleNode>(bus::parse_flags(argc, argv)); });
}
