// Messages between nodes, with the software at both ends and the host's link.
#pragma once

#include <cstdint>
#include <vector>

#include "host/timing/replay/processor.hpp"
#include "host/timing/replay/ring.hpp"

namespace pxpl5::host::timing {

/// The ring's places: host, GPs, Renderers, frame buffers' ports.
struct Places {
    explicit Places(const Machine& machine);

    Place host() const { return 0; }
    Place gp(std::size_t index) const { return static_cast<Place>(1 + index); }
    Place renderer(std::size_t index) const { return static_cast<Place>(1 + gps + index); }
    Place port(std::size_t index) const { return static_cast<Place>(1 + gps + renderers + index); }
    bool is_gp(Place place) const { return place >= 1 && place <= gps; }
    std::size_t count() const { return 1 + gps + renderers + ports; }

    std::size_t gps = 0, renderers = 0;
    std::size_t ports = 0;  ///< Ports of all frame buffers.
};

/// Sends messages and says when they are taken. Renderers and frame buffers have no software.
class Mail {
  public:
    Mail(const Places& places, const Costs& costs, Events& events, Ring& ring,
         std::vector<Processor>& gps)
        : places_(places), costs_(costs), events_(events), ring_(ring), gps_(gps) {}

    /// `taken` is called when the destination has it, its software included.
    void send(Place source, Place destination, std::uint64_t words, Callback<> taken);

    /// The host's software.
    const Meter& host() const { return host_; }
    const Meter& link() const { return link_; }

  private:
    struct Letter {
        Place source = 0, destination = 0;
        std::uint64_t words = 0;
        Callback<> taken;
    };

    /// When it has crossed the host's link.
    Ns crossed(std::uint32_t letter);
    void from_host(std::uint32_t letter);
    void to_ring(std::uint32_t letter);
    void arrive(std::uint32_t letter);
    void to_host(std::uint32_t letter);
    void take(std::uint32_t letter);

    const Places& places_;
    const Costs& costs_;
    Events& events_;
    Ring& ring_;
    std::vector<Processor>& gps_;
    Meter host_, link_;
    std::vector<Letter> letters_;
    std::vector<std::uint32_t> free_letters_;
};

}  // namespace pxpl5::host::timing
