#include "host/machine/computers/placement.hpp"

#include <doctest/doctest.h>

#include <algorithm>

#include "host/base/error.hpp"

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
