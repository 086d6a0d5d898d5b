#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "host/base/error.hpp"
#include "host/timing/fit.hpp"
#include "tests/host/timing/cases.hpp"

namespace pxpl5::host::timing {

using namespace testing;

namespace {

const Parameter* named(std::string_view name) {
    return &*std::ranges::find(parameters(), name, &Parameter::name);
}

const std::array fitted = {named("gp.edge_cycles"), named("gp.build_triangle_cycles"),
                           named("gp.draw_primitive_cycles")};

/// Cases whose stated times are those of `machine`.
std::vector<PaperCase> cases_made_by(const Machine& machine) {
    std::vector<PaperCase> cases = {small_case(40, 10, 60), small_case(20, 300, 20),
                                    small_case(30, 150, 200)};
    for (PaperCase& each : cases) {
        const CaseTime time = time_of(machine, each);
        each.row.paper.built_ms = time.built_ms;
        each.row.paper.frames_per_s = time.rate.frames_per_s;
    }
    return cases;
}

Machine machine_to_find() {
    Machine machine = small_machine();
    machine.gp_edge_cycles = 137;
    machine.gp_build_triangle_cycles = 1490;
    machine.gp_draw_primitive_cycles = 1620;
    return machine;
}

std::string refusal(const Machine& machine, std::span<const Parameter* const> parameters,
                    const std::vector<PaperCase>& cases) {
    try {
        fit(machine, parameters, cases);
    } catch (const RequestError& error) {
        CHECK(error.code == ExitCode::bad_data);
        return error.what();
    }
    return "no error";
}

}  // namespace

TEST_CASE("times made with known parameters give these parameters back") {
    std::vector<PaperCase> cases = cases_made_by(machine_to_find());
    cases.push_back(small_case(10, 10, 10));  // Its times are wrong, but it is held back.
    cases.back().row.held_back = true;
    Machine start = small_machine();
    start.gp_edge_cycles = 100;
    start.gp_build_triangle_cycles = 2500;
    start.gp_draw_primitive_cycles = 1000;
    int last_run = 0;
    const Fit found = fit(start, fitted, cases, [&](int runs) { CHECK(runs == ++last_run); });
    CHECK(found.cases_used == 3);
    CHECK(found.runs == last_run);
    REQUIRE(found.values.size() == 3);
    CHECK(found.values[0].parameter == fitted[0]);
    CHECK(found.values[0].start == 100);
    CHECK(found.values[0].value == doctest::Approx(137).epsilon(0.01));
    CHECK(found.values[1].value == doctest::Approx(1490).epsilon(0.01));
    CHECK(found.values[2].value == doctest::Approx(1620).epsilon(0.01));
    CHECK(found.machine.gp_draw_primitive_cycles == found.values[2].value);
    CHECK(found.machine.gp_message_us == start.gp_message_us);
    CHECK(found.deviation < 0.005);
}

TEST_CASE("twice too slow weighs as much as twice too quick") {
    // The same work, said to take a time and four times that: the fit is in between, at twice.
    const Machine machine = [] {
        Machine made = small_machine();
        made.host_message_us = made.gp_message_us = made.gp_build_triangle_cycles = 0;
        made.host_link_mb_s = 1e6;
        made.gp_edge_cycles = 100;
        return made;
    }();
    std::vector<PaperCase> cases(2, small_case(100, 0, 1));
    const CaseTime time = time_of(machine, cases[0]);
    for (PaperCase& each : cases) {
        each.row.paper.built_ms = time.built_ms;
        each.row.paper.frames_per_s = time.rate.frames_per_s;
    }
    cases[1].row.paper.built_ms *= 4;
    const std::array edge = {fitted[0]};
    const Fit found = fit(machine, edge, cases);
    CHECK(found.values[0].value == doctest::Approx(200).epsilon(0.01));
    CHECK(found.deviation == doctest::Approx(std::log(2) / std::sqrt(2)).epsilon(0.01));
}

TEST_CASE("what cannot be fitted is refused") {
    const std::vector<PaperCase> cases = cases_made_by(machine_to_find());
    const Machine machine = small_machine();
    CHECK(refusal(machine, {}, cases).find("0 parameters, at least 1") != std::string::npos);
    CHECK(refusal(machine, fitted, {cases[0]}).find("1 cases have 2") != std::string::npos);
    Machine zero = machine;
    zero.gp_edge_cycles = 0;
    CHECK(refusal(zero, fitted, cases).find("gp.edge_cycles is 0, must be") != std::string::npos);
    std::vector<PaperCase> broken = cases;
    broken[1].volume.runs.clear();
    CHECK(refusal(machine, fitted, broken).find("runs of 0 slices") != std::string::npos);
}

TEST_CASE("a value is rounded to so many digits") {
    CHECK(rounded(1234.5, 3) == 1230);
    CHECK(rounded(0.0098765, 3) == doctest::Approx(0.00988));
    CHECK(rounded(999.9, 3) == 1000);
    CHECK(rounded(0, 3) == 0);
}

TEST_CASE("the parameters to fit are those that the topology calls fitted") {
    Topology topology = load_topology("paper-1993");
    for (TimingValue& entry : topology.timing) {
        entry.provenance = entry.name == "gp.message_us" || entry.name == "ring.fifo_words"
                               ? Provenance::fitted
                               : Provenance::ours;
    }
    const auto chosen = fitted_parameters(topology);
    REQUIRE(chosen.size() == 2);
    CHECK(chosen[0]->name == "gp.message_us");
    CHECK(chosen[1]->name == "ring.fifo_words");
}

}  // namespace pxpl5::host::timing
