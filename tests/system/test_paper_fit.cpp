// The fitted parameters of the paper's machine are what its rows give, on real processes.
#include <doctest/doctest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "host/machine/machine.hpp"
#include "host/report/measure.hpp"
#include "host/timing/fit.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

/// The phantoms' rows, counted by two GPs and two Renderers: counts do not depend on how many.
std::vector<timing::PaperCase> counted_cases() {
    MachineOptions options;
    options.binaries = PXPL5_BIN_DIR;
    options.run_base =
        std::filesystem::temp_directory_path() / ("pxpl5-fit-" + std::to_string(getpid()));
    Topology topology = load_topology("default", {"gp.count=2", "renderer.count=2", "record=off"});
    std::vector<timing::PaperCase> cases;
    {
        Machine machine(topology, options);
        Session session(machine);
        const std::vector<report::Source> sources = report::sources_of("", {});
        for (report::MeasuredCase& each :
             report::measure(session, sources, {false, false, "", {}})) {
            cases.push_back(std::move(each.work));
        }
        machine.shutdown();
    }
    std::filesystem::remove_all(options.run_base);
    return cases;
}

}  // namespace

TEST_CASE("fitting again gives the file's values, and every phantom's row is within its bounds") {
    const Topology paper = load_topology("paper-1993");
    const std::vector<timing::PaperCase> cases = counted_cases();
    REQUIRE(cases.size() == 5);
    const timing::Machine machine = timing::machine_of(paper);
    const auto fitted = timing::fitted_parameters(paper);
    REQUIRE(fitted.size() == 3);
    const timing::Fit found = timing::fit(machine, fitted, cases);
    CHECK(found.cases_used == 3);
    for (const timing::FittedValue& each : found.values) {
        CHECK_MESSAGE(std::abs(each.value / each.start - 1) <= 0.02,
                      std::string(each.parameter->name), " ", each.start, " ", each.value);
    }
    for (const timing::PaperCase& each : cases) {
        const timing::CaseTime time = timing::time_of(machine, each);
        CAPTURE(std::string(each.row.volume));
        CAPTURE(std::string(each.row.surface));
        CHECK(std::abs(time.built_error_percent) <= 20);
        CHECK(std::abs(time.rate_error_percent) <= 15);
    }
}
