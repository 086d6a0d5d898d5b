#include <doctest/doctest.h>

#include <cstring>
#include <map>
#include <random>

#include "host/base/error.hpp"
#include "host/inspect/step/stepper.hpp"
#include "tests/host/inspect/recorded_machine.hpp"
#include "tests/isa/random_program.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
namespace inspect = host::inspect;
using inspect::Direction;
using inspect::RunPlace;
using renderer::fast::Fast;

namespace {

constexpr std::uint32_t z_address = isa::region::z.address, z_width = isa::region::z.width;

/// Two frames of a ball over four regions, the lower and right ones small.
struct Ball {
    Ball() : recorded(machine()) {
        host::Session& session = recorded.session;
        session.scene.size = {150, 140};
        session.volumes.load("phantom:sphere");
        session.surfaces.set("ball", 100, CaseRule::watertight, {200, 100, 50});
        session.frames.draw();
        session.frames.draw();
        run = std::make_unique<inspect::RecordedRun>(recorded.run());
    }
    static host::Topology machine() {
        host::Topology topology;
        topology.gp.count = 2;
        topology.renderer.count = 2;
        topology.frame_buffer.count = 1;
        return topology;
    }
    test::RecordedMachine recorded;
    std::unique_ptr<inspect::RecordedRun> run;
};

/// Made once: no test changes it.
const inspect::RecordedRun& ball() {
    static const Ball made;
    return *made.run;
}

bool same(const Fast& p, const Fast& q) {
    return std::memcmp(&p.pixels(), &q.pixels(), sizeof p.pixels()) == 0;
}

/// Calls check(walk before the instruction, executor before, action that executes it) over a
/// frame, from the definition of a walk alone.
template <typename Visit>
void walk_frame(const inspect::RecordedFrame& frame, const Visit& visit) {
    for (const auto& [number, region] : frame.regions) {
        Fast executor;
        inspect::RegionWalk walk(region.plan, executor);
        while (!walk.done()) {
            visit(region, walk, executor);
        }
    }
}

using Places = std::vector<RunPlace>;

/// All places at which `stop` holds, as continuing forward finds them.
Places forward(inspect::Stepper& stepper, const inspect::Break& stop) {
    Places places;
    while (stepper.run_to({&stop, 1}, Direction::forward)) {
        places.push_back(stepper.place());
    }
    return places;
}

/// The same, backward; in forward order.
Places backward(inspect::Stepper& stepper, const inspect::Break& stop) {
    Places places;
    while (stepper.run_to({&stop, 1}, Direction::backward)) {
        places.insert(places.begin(), stepper.place());
    }
    return places;
}

/// Continues through both frames and back, and compares with what a plain walk says.
/// holds_before(walk, executor)   at a place ahead of an instruction
template <typename Holds>
void check_stops(const inspect::Break& stop, const Holds& places_of_frame) {
    Places expected;
    for (const std::uint32_t frame : ball().frames()) {
        places_of_frame(ball().frame(frame), expected);
    }
    // Snapshots come at any place of a triangle's ten instructions, its first included.
    const inspect::StepLimits limits{.snapshot_every = 129};
    inspect::Stepper stepper(ball(), ball().frames().front(), limits);
    Places found;
    if (!expected.empty() && expected.front() == stepper.place()) {
        found.push_back(stepper.place());  // Continuing goes to places behind the present one.
    }
    for (const RunPlace& place : forward(stepper, stop)) {
        found.push_back(place);
    }
    REQUIRE(expected.size() >= 2);
    CHECK(found == expected);
    CHECK(stepper.here().done());
    const bool end_counts = expected.back() == stepper.place();
    Places back = backward(stepper, stop);
    if (end_counts) {
        back.push_back(expected.back());
    }
    CHECK(back == expected);
    CHECK(stepper.place() == RunPlace{ball().frames().front(), 0, 0});
}

}  // namespace

TEST_CASE("every place of a region, reached from anywhere, has the pixels of a plain walk") {
    const inspect::RecordedFrame frame = ball().frame(0);
    const inspect::RecordedRegion& region = frame.regions.at(0);
    const std::uint64_t seed = test::seed_or<std::uint64_t>(5);
    INFO("PXPL5_SEED=", seed);
    std::mt19937_64 random(seed);
    Fast executor;
    inspect::RegionWalk plain(region.plan, executor);
    const std::size_t one = executor.save().bytes();
    // Memory for five snapshots: they are thinned out while the first walk goes on.
    inspect::RegionStepper stepper(region.plan, {.snapshot_every = 64, .snapshot_bytes = 5 * one});
    while (!plain.done()) {
        plain.step();
        const std::uint64_t here = plain.counts().instructions;
        if (random() % 97 != 0 && !plain.done()) {
            continue;
        }
        stepper.seek(random() % (here + 50));
        stepper.seek(here);
        REQUIRE(stepper.executed() == here);
        REQUIRE(same(stepper.executor(), executor));
        REQUIRE(stepper.done() == plain.done());
        REQUIRE((plain.done() || stepper.walk().at() == plain.at()));
        REQUIRE(stepper.walk().counts().cycles == plain.counts().cycles);
        CHECK(stepper.snapshots() <= 5);
    }
    CHECK(stepper.snapshots() >= 2);
    stepper.seek(plain.counts().instructions + 1000);
    CHECK(stepper.executed() == plain.counts().instructions);
}

TEST_CASE("stepping back undoes stepping on, over the borders of regions and frames") {
    inspect::Stepper stepper(ball(), 0);
    std::vector<RunPlace> places{stepper.place()};
    // The stretch from the end of the last region of frame 0 into frame 1.
    stepper.go_to({0, 3, ~std::uint64_t{0}});
    for (int i = 0; i < 20; ++i) {
        REQUIRE(stepper.back());
    }
    places = {stepper.place()};
    for (int i = 0; i < 60; ++i) {
        REQUIRE(stepper.step());
        places.push_back(stepper.place());
    }
    CHECK(places.front().frame == 0);
    CHECK(places.back().frame == 1);
    for (std::size_t i = places.size() - 1; i > 0; --i) {
        REQUIRE(stepper.place() == places[i]);
        REQUIRE(stepper.back());
    }
    CHECK(stepper.place() == places.front());
}

TEST_CASE("the run has a begin and an end") {
    inspect::Stepper stepper(ball(), 0);
    CHECK_FALSE(stepper.back());
    CHECK_FALSE(stepper.to_region(Direction::backward));
    CHECK(stepper.place() == RunPlace{0, 0, 0});
    CHECK(stepper.to_region(Direction::forward));
    CHECK(stepper.place() == RunPlace{0, 1, 0});
    CHECK(stepper.to_frame(Direction::forward));
    CHECK(stepper.place() == RunPlace{1, 0, 0});
    stepper.step();
    CHECK(stepper.to_frame(Direction::backward));
    CHECK(stepper.place() == RunPlace{1, 0, 0});
    CHECK(stepper.to_frame(Direction::backward));
    CHECK(stepper.place() == RunPlace{0, 0, 0});
    stepper.go_to({1, 3, 7});
    CHECK(stepper.place() == RunPlace{1, 3, 7});
    CHECK(stepper.to_region(Direction::backward));
    CHECK(stepper.place() == RunPlace{1, 3, 0});
    stepper.go_to({1, 3, ~std::uint64_t{0}});
    CHECK_FALSE(stepper.step());
    CHECK_THROWS_WITH(stepper.go_to({1, 9, 0}),
                      "frame 1 has no region 9 that can be executed: it has none");
}

TEST_CASE("an opcode's breakpoint holds ahead of each instruction of that name") {
    check_stops(inspect::OpBreak{"treelt*"}, [](const auto& frame, Places& places) {
        walk_frame(frame, [&](const auto& region, auto& walk, Fast&) {
            if (isa::info(walk.next().op).name == "TREEltMEM") {
                places.push_back({frame.number, region.place.number, walk.counts().instructions});
            }
            walk.step();
        });
    });
}

TEST_CASE("a part's breakpoint holds at prologue, every segment and the end of region") {
    check_stops(inspect::PartBreak{}, [](const auto& frame, Places& places) {
        walk_frame(frame, [&](const auto& region, auto& walk, Fast&) {
            places.push_back({frame.number, region.place.number, walk.counts().instructions});
            walk.run_part();
        });
    });
}

TEST_CASE("a pixel's breakpoint holds behind each instruction that writes its memory") {
    // Pixel (70, 60) of the picture. Changes come from writes; a write need not change anything,
    // so the definition is taken: an enabled pixel, and a row that writes memory.
    check_stops(inspect::PixelBreak{70, 60}, [](const auto& frame, Places& places) {
        walk_frame(frame, [&](const auto& region, auto& walk, Fast& executor) {
            const isa::Effects effects = isa::info(walk.next().op).effects;
            const bool writes = (effects & isa::mem) != 0 &&
                                (executor.enabled(70, 60) || (effects & isa::all) != 0);
            walk.step();
            if (writes && region.place.number == 0) {
                places.push_back({frame.number, 0, walk.counts().instructions});
            }
        });
    });
}

TEST_CASE("a depth's breakpoint holds where z falls below the value") {
    const inspect::DepthBreak stop{70, 60, isa::region::z_far};
    check_stops(stop, [&](const auto& frame, Places& places) {
        walk_frame(frame, [&](const auto& region, auto& walk, Fast& executor) {
            const auto z = [&] { return executor.field(70, 60, z_address, z_width); };
            const std::uint64_t before = z();
            walk.step();
            if (region.place.number == 0 && before >= stop.below && z() < stop.below) {
                places.push_back({frame.number, 0, walk.counts().instructions});
            }
        });
    });
}

TEST_CASE("the breakpoint of no enabled pixel holds where the last one is disabled") {
    check_stops(inspect::EmptyBreak{}, [](const auto& frame, Places& places) {
        walk_frame(frame, [&](const auto& region, auto& walk, Fast& executor) {
            const bool before = executor.any_enabled();
            walk.step();
            if (before && !executor.any_enabled()) {
                places.push_back({frame.number, region.place.number, walk.counts().instructions});
            }
        });
    });
}

TEST_CASE("a primitive's breakpoint holds at its SETENABS, and by cell at those of one cell") {
    const auto begins = [](const auto& frame, Places& places, auto wanted) {
        walk_frame(frame, [&](const auto& region, auto& walk, Fast&) {
            std::map<inspect::Address, inspect::Primitive> firsts;
            for (const inspect::Primitive& p : inspect::primitives_of(frame, region)) {
                firsts.emplace(p.address(), p);
            }
            while (!walk.done()) {
                const auto first = firsts.find(walk.at());
                if (first != firsts.end() && wanted(region, first->second)) {
                    places.push_back(
                        {frame.number, region.place.number, walk.counts().instructions});
                }
                walk.step();
            }
        });
    };
    check_stops(inspect::PrimitiveBreak{}, [&](const auto& frame, Places& places) {
        begins(frame, places, [](const auto&, const auto&) { return true; });
    });
    const inspect::RecordedFrame frame = ball().frame(0);
    const auto primitives = inspect::primitives_of(frame, frame.regions.at(0));
    const inspect::Primitive& some = primitives.at(primitives.size() / 3);
    REQUIRE(some.origin);
    const std::uint32_t i = some.origin->i(), j = some.origin->j();
    const std::uint32_t k = frame.regions.at(0).plan.parts[some.part].segment.slab;
    inspect::PrimitiveBreak stop;
    stop.cell = {i, j, k};
    check_stops(stop, [&](const auto& f, Places& places) {
        begins(f, places, [&](const auto& region, const inspect::Primitive& p) {
            return p.origin->i() == i && p.origin->j() == j &&
                   region.plan.parts[p.part].segment.slab == k;
        });
    });
}

TEST_CASE("an address's breakpoint holds there, in its region, in every frame") {
    const inspect::Address address{1, 34};
    check_stops(inspect::AddressBreak{0, address}, [&](const auto& frame, Places& places) {
        walk_frame(frame, [&](const auto& region, auto& walk, Fast&) {
            if (region.place.number == 0 && walk.at() == address) {
                places.push_back({frame.number, 0, walk.counts().instructions});
            }
            walk.step();
        });
    });
}
