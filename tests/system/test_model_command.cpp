// The command `model`: what another machine would have taken for the session's scene.
#include <doctest/doctest.h>

#include <string>

#include "host/base/error.hpp"
#include "host/commands/commands.hpp"
#include "host/session/live_work.hpp"
#include "host/timing/picture.hpp"
#include "tests/system/simulated_machine.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

/// Two surfaces of the letters.
struct Bench {
    Bench(int gps, int renderers) : machine(plan(gps, renderers)), session(machine) {
        session.volumes.load("phantom:letters");
        session.scene.size = {300, 200};
        const double middle =
            (session.volumes.volume().minimum + session.volumes.volume().maximum) / 2;
        session.surfaces.set("outer", middle, CaseRule::watertight, {200, 180, 160});
        session.surfaces.set("inner", middle * 1.2, CaseRule::watertight, {90, 120, 160});
    }
    static Topology plan(int gps, int renderers) {
        Topology topology;
        topology.gp.count = gps;
        topology.renderer.count = renderers;
        topology.frame_buffer.count = 1;
        topology.seed = 1;
        return topology;
    }
    Reply run(const std::string& line) { return run_command(session, parse_line(line)); }
    std::string refusal(const std::string& line) {
        try {
            run(line);
        } catch (const RequestError& error) {
            return error.what();
        }
        return "taken";
    }

    test::SimulatedMachine machine;
    Session session;
};

const FieldValue& at(const Fields& fields, std::string_view name) {
    const auto found = std::ranges::find(fields, name, &Field::name);
    REQUIRE_MESSAGE(found != fields.end(), name);
    return found->value;
}
const Fields& group(const Fields& fields, std::string_view name) {
    return std::get<Fields>(at(fields, name));
}
double number(const Fields& fields, std::string_view name) {
    return std::get<double>(at(fields, name));
}

double ms(const timing::StepTime& step) {
    return static_cast<double>(step.end - step.begin) / 1e6;
}

}  // namespace

TEST_CASE("model tells what the replay of the session's work says, step by step") {
    Bench bench(2, 3);
    const Fields told = bench.run("model").fields;
    const timing::RunWork run = live_work(bench.session);
    const timing::Machine machine = timing::machine_of(load_topology("paper-1993"));
    const timing::RunTime time = simulate(machine, run);
    REQUIRE(time.steps.size() == 4);
    CHECK(std::get<std::string>(at(told, "machine")) == "paper-1993");
    CHECK(std::get<std::int64_t>(at(told, "gps")) == machine.gps);
    CHECK(number(group(told, "load"), "ms") == ms(time.steps[0]));
    const auto& surfaces = std::get<std::vector<Fields>>(at(told, "surfaces"));
    REQUIRE(surfaces.size() == 2);
    for (std::size_t i = 0; i < 2; ++i) {
        const std::string name = i == 0 ? "outer" : "inner";
        CHECK(std::get<std::string>(at(surfaces[i], "name")) == name);
        CHECK(std::get<std::int64_t>(at(surfaces[i], "triangles")) ==
              bench.session.surfaces.report_of(name).triangles);
        CHECK(number(surfaces[i], "ms") == ms(time.steps[1 + i]));
    }
    const timing::Rate rate = frame_rate(machine, std::get<timing::FrameWork>(run.steps.back()));
    const Fields& frame = group(told, "frame");
    CHECK(number(frame, "frames_per_s") == rate.frames_per_s);
    CHECK(std::get<std::string>(at(frame, "limit")) == timing::name_of(rate.limit));
    const auto& use = std::get<std::vector<Fields>>(at(frame, "use"));
    REQUIRE(use.size() == rate.use.size());
    for (std::size_t i = 0; i < use.size(); ++i) {
        CHECK(std::get<std::string>(at(use[i], "unit")) == timing::name_of(rate.use[i].unit));
        CHECK(number(use[i], "busiest") == rate.use[i].busiest);
        CHECK(number(use[i], "mean") == rate.use[i].mean);
    }
}

TEST_CASE("what model says depends on the machine that is named, not on the one that runs") {
    Bench small(1, 1), large(5, 4);
    CHECK(json_text(small.run("model").fields) == json_text(large.run("model").fields));
    const Fields usual = small.run("model").fields;
    const Fields slow = small.run("model paper-1993 renderer.clock_mhz=4 renderer.count=1").fields;
    CHECK(std::get<std::int64_t>(at(slow, "renderers")) == 1);
    CHECK(number(group(slow, "frame"), "frames_per_s") <
          number(group(usual, "frame"), "frames_per_s"));
    CHECK(std::get<std::string>(at(group(slow, "frame"), "limit")) == "Renderer");
    // Pictures wait for the retrace.
    const Reply seldom = small.run("model paper-1993 frame_buffer.refresh_hz=1");
    CHECK(std::get<std::string>(at(group(seldom.fields, "frame"), "limit")) == "waiting");
    CHECK(seldom.text.find("; limit waiting, GP ") != std::string::npos);
    CHECK(number(group(slow, "load"), "ms") == number(group(usual, "load"), "ms"));
    CHECK(small.run("model").text.find("surface inner: ") != std::string::npos);
}

TEST_CASE("a picture of several samples is all its passes, shown over and over") {
    Bench bench(1, 2);
    const double once = number(group(bench.run("model").fields, "frame"), "latency_ms");
    bench.run("antialias 4");
    const Fields frame = group(bench.run("model").fields, "frame");
    CHECK(std::get<std::int64_t>(at(frame, "samples")) == 4);
    CHECK(number(frame, "latency_ms") > once);
    const timing::RunWork run = live_work(bench.session);
    const timing::Rate rate = picture_rate(timing::machine_of(load_topology("paper-1993")),
                                           timing::pictures_of(run).at(0));
    CHECK(number(frame, "frames_per_s") == rate.frames_per_s);
}

TEST_CASE("model refuses what it does not know, by name, before it draws") {
    Bench bench(1, 1);
    const std::uint32_t before = bench.session.frames.last().frame;
    CHECK(bench.refusal("model nowhere").find("nowhere") != std::string::npos);
    CHECK(bench.refusal("model gp.edge_cycle=3").find("did you mean 'gp.edge_cycles'") !=
          std::string::npos);
    CHECK(bench.refusal("model gp.edge_cycles=much").find("gp.edge_cycles") != std::string::npos);
    CHECK(bench.refusal("model gp.count=2000").find("2000") != std::string::npos);
    CHECK(bench.session.frames.last().frame == before);
    // With another number of Renderers, the recorded assignment does not apply.
    CHECK(bench.refusal("model assignment=recorded").find("Renderers") != std::string::npos);
}

TEST_CASE("without a volume there is nothing to model") {
    test::SimulatedMachine machine(Bench::plan(1, 1));
    Session session(machine);
    CHECK_THROWS_WITH_AS(run_command(session, parse_line("model")),
                         "no volume is loaded; load one first: load VOLUME", RequestError);
}
