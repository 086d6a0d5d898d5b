// A node process for the tests of run_process: sends each RemoveSurface back to its sender.
#include <stdexcept>

#include "ringbus/process/process.hpp"

namespace {

using namespace pxpl5;

class EchoNode final : public bus::Node {
  public:
    void receive(const bus::Message& message, bus::Outbox& out) override {
        if (const auto* topology = message.as<bus::schema::Topology>()) {
            peers_ = topology->nodes()->size();
        } else if (const auto* order = message.as<bus::schema::RemoveSurface>()) {
            if (order->surface() == 0xffff) {
                throw std::logic_error("as ordered");
            }
            bus::schema::SetSurfaceT answer;
            answer.surface = order->surface();
            answer.revision = static_cast<std::uint32_t>(peers_);
            out.send(bus::host_id, bus::pack(answer));
        }
    }
    bool work(bus::Outbox&) override { return false; }

  private:
    std::size_t peers_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
    return bus::run_process(argc, argv, bus::schema::Role::gp,
                            [] { return std::make_unique<EchoNode>(); });
}
