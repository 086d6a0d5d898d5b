// A node process for the tests of run_process: answers the number of each
// RemoveSurface and BeginFrame with a SurfaceBuilt to the host.
#include <new>
#include <stdexcept>

#include "ringbus/process/process.hpp"

namespace {

using namespace pxpl5;

class EchoNode final : public bus::Node {
  public:
    void receive(const bus::Message& message, bus::Outbox& out) override {
        if (const auto* topology = message.as<bus::schema::Topology>()) {
            if (topology->gp_memory_bytes() == 1) {
                throw std::bad_alloc();  // As ordered.
            }
            peers_ = topology->nodes()->size();
        } else if (const auto* order = message.as<bus::schema::RemoveSurface>()) {
            if (order->surface() == 0xffff) {
                throw std::logic_error("as ordered");
            }
            answer(order->surface(), out);
        } else if (const auto* begin = message.as<bus::schema::BeginFrame>()) {
            answer(static_cast<std::uint16_t>(begin->draw()->frame()), out);
        }
    }
    bool work(bus::Outbox&) override { return false; }

  private:
    void answer(std::uint16_t number, bus::Outbox& out) const {
        bus::schema::SurfaceBuiltT built;
        built.surface = number;
        built.revision = static_cast<std::uint32_t>(peers_);
        out.send(bus::host_id, bus::pack(built));
    }

    std::size_t peers_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
    return bus::run_process(argc, argv, bus::schema::Role::gp,
                            [] { return std::make_unique<EchoNode>(); });
}
