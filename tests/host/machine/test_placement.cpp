#include "host/machine/computers/placement.hpp"

#include <doctest/doctest.h>

#include <algorithm>

#include "host/base/error.hpp"
#include "host/machine/computers/plan_text.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using bus::schema::Role;

namespace {

struct Placed {
    Roster roster;
    std::vector<int> places;

    std::vector<int> of(Role role) const {
        std::vector<int> found;
        for (std::size_t i = 0; i < roster.size(); ++i) {
            if (roster[i].role == role) {
                found.push_back(places[i]);
            }
        }
        return found;
    }
};

Placed place(int gps, int renderers, const std::vector<ComputerSlots>& computers,
             const std::vector<std::string>& overrides = {}) {
    Topology topology = load_topology("one-of-each", overrides);
    topology.gp.count = gps;
    topology.renderer.count = renderers;
    const Roster roster = roster_of(topology);
    return {roster, place_nodes(roster, topology, computers)};
}

}  // namespace

TEST_CASE("placement: host and frame buffer stay on the host's computer") {
    const Placed placed = place(3, 2, {{"n1", 2}, {"n2", 2}});
    CHECK(placed.of(Role::host) == std::vector<int>{own_computer});
    CHECK(placed.of(Role::frame_buffer) == std::vector<int>{own_computer});
}

TEST_CASE("placement: pack uses the fewest computers, Renderers together") {
    const Placed placed = place(4, 2, {{"n1", 4}, {"n2", 4}, {"n3", 4}});
    CHECK(placed.of(Role::renderer) == std::vector<int>{1, 1});
    CHECK(placed.of(Role::gp) == std::vector<int>{1, 1, 2, 2});
}

TEST_CASE("placement: spread uses all computers in proportion to their slots") {
    const Placed placed = place(6, 3, {{"n1", 2}, {"n2", 4}, {"n3", 3}}, {"placement=spread"});
    std::vector<int> nodes = placed.of(Role::gp);
    const std::vector<int> renderers = placed.of(Role::renderer);
    nodes.insert(nodes.end(), renderers.begin(), renderers.end());
    CHECK(std::ranges::count(nodes, 1) == 2);
    CHECK(std::ranges::count(nodes, 2) == 4);
    CHECK(std::ranges::count(nodes, 3) == 3);
}

TEST_CASE("placement: more nodes than slots are spread in proportion") {
    const Placed placed = place(36, 16, {{"n1", 2}, {"n2", 4}});
    std::vector<int> nodes = placed.of(Role::gp);
    const std::vector<int> renderers = placed.of(Role::renderer);
    nodes.insert(nodes.end(), renderers.begin(), renderers.end());
    CHECK(std::abs(std::ranges::count(nodes, 2) - 2 * std::ranges::count(nodes, 1)) <= 2);
    CHECK(std::ranges::count(nodes, own_computer) == 0);
}

TEST_CASE("placement: a topology names the computers of a role") {
    const Placed placed =
        place(4, 1, {{"n1", 8}, {"n2", 8}}, {"gp.computer=n2,n1", "frame_buffer.computer=n2"});
    CHECK(placed.of(Role::gp) == std::vector<int>{2, 1, 2, 1});
    CHECK(placed.of(Role::frame_buffer) == std::vector<int>{2});
    CHECK(placed.of(Role::renderer) == std::vector<int>{1});
}

TEST_CASE("placement: a computer that is not there is named with those that are") {
    try {
        place(1, 1, {{"n1", 8}, {"n2", 8}}, {"gp.computer=n3"});
        FAIL("placed");
    } catch (const RequestError& error) {
        CHECK(error.code == ExitCode::usage);
        CHECK(std::string(error.what()) ==
              "gp-0 shall run on computer 'n3', but only n1, n2 are there");
    }
}

TEST_CASE("plan: what crosses the network follows from the places") {
    const auto forecast = [](const Placed& placed) {
        return network_forecast(placed.roster, placed.places, 512, 512, Recording::off);
    };
    // All GPs and Renderers on n1: 16 regions of 128 x 128 pixels, and no program.
    const NetworkForecast together = forecast(place(2, 2, {{"n1", 4}}));
    CHECK(together.pixel_bytes == 512 * 512 * 4);
    CHECK(together.picture_bytes == 0);
    CHECK(together.bytes_per_triangle == 0);
    // GPs on n1 and n2, both Renderers on n1: the programs of half of the GPs.
    const NetworkForecast apart = forecast(place(4, 2, {{"n1", 4}, {"n2", 4}}, {"placement=pack"}));
    CHECK(apart.bytes_per_triangle == 34 * 4 * 0.5);
    // A record of the run needs the 8 bytes of each triangle's origin, too.
    const Placed recorded = place(4, 2, {{"n1", 4}, {"n2", 4}}, {"placement=pack"});
    CHECK(network_forecast(recorded.roster, recorded.places, 512, 512, Recording::flight)
              .bytes_per_triangle == (34 * 4 + 8) * 0.5);
    // A frame buffer beside the Renderers: the picture crosses instead of the regions.
    const NetworkForecast beside = forecast(place(2, 2, {{"n1", 4}}, {"frame_buffer.computer=n1"}));
    CHECK(beside.pixel_bytes == 0);
    CHECK(beside.picture_bytes == 512 * 512 * 4);
    // One pixel more is a row and a column of regions more.
    const Placed placed = place(2, 2, {{"n1", 4}});
    CHECK(network_forecast(placed.roster, placed.places, 513, 513, Recording::off).pixel_bytes ==
          25 * 128 * 128 * 4);
}

TEST_CASE("plan: the text has the nodes of each computer, or what is missing") {
    const auto text = [](const std::vector<std::string>& overrides) {
        return plan_text(load_topology("paper-1993", overrides));
    };
    CHECK(text({}).empty());
    CHECK(text({"engine=ssh", "computers=n1:30,n2"}) ==
          "plan: the cores of n2 are unknown before it has joined; say how many nodes it takes to "
          "see the plan, for example n2:8\n");
    CHECK(text({"engine=slurm", "wait=2"}).starts_with("plan: unknown before the computers have"));
    CHECK(text({"engine=ssh", "computers=n1:30,n2:22"}) ==
          "plan:\n"
          "  this computer     2 nodes  host, framebuffer-0\n"
          "  n1               30 nodes  gp-0..13, renderer-0..15\n"
          "  n2               22 nodes  gp-14..35\n"
          "expected between computers, for a frame of 512 x 512 pixels: 1.05 MB of pixels,\n"
          "and 0.88 MB for each 10000 triangles in sight, once for each region that they touch\n");
    CHECK(text({"engine=ssh", "computers=n1:8,n2:8"}).find("(more than its 8 slots)") !=
          std::string::npos);
}
