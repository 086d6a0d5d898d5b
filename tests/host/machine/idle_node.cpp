// A node that does nothing, or misbehaves on request: what the launcher's tests launch.
//
// MISBEHAVE in the environment: "build" says Hello with another build, "silent" never says Hello,
// "deaf" ignores Shutdown and SIGTERM. RemoveSurface{n} is an order, see Order.
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

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

class IdleNode final : public bus::Node {
  public:
    void receive(const bus::Message& message, bus::Outbox& out) override {
        const auto* order = message.as<schema::RemoveSurface>();
        if (order == nullptr) {
            return;
        }
        switch (static_cast<test::Order>(order->surface())) {
            case test::Order::answer:
                out.send(bus::host_id, bus::pack(schema::VolumeReadyT{}));
                return;
            case test::Order::chatter:
                for (int i = 0; i < test::chatter_messages; ++i) {
                    out.send(bus::host_id, bus::pack(schema::VolumeReadyT{}));
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
        }
    }
    bool work(bus::Outbox&) override { return false; }
};

void say_hello_as_another_build(int argc, char** argv) {
    const bus::ProcessFlags flags = bus::parse_flags(argc, argv);
    bus::ZmqLink link(flags.node_id, flags.bind);
    link.add_peer(bus::host_id, flags.host_endpoint);
    schema::HelloT hello;
    hello.role = role;
    hello.index = flags.index;
    hello.pid = static_cast<std::uint32_t>(getpid());
    hello.endpoint = link.endpoint();
    hello.build = "another build";
    hello.schema_hash = bus::schema_hash();
    link.send(bus::host_id, bus::pack(hello));
    stay_for_ever();
}

}  // namespace

int main(int argc, char** argv) {
    const char* how = std::getenv("MISBEHAVE");
    const std::string misbehave = how == nullptr ? "" : how;
    if (misbehave == "build") {
        say_hello_as_another_build(argc, argv);
    } else if (misbehave == "silent") {
        stay_for_ever();
    } else if (misbehave == "deaf") {
        std::signal(SIGTERM, SIG_IGN);
        std::atexit(stay_for_ever);
    }
    return bus::run_process(argc, argv, role, [] { return std::make_unique<IdleNode>(); });
}
