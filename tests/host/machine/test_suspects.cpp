// Whoever listens is told of nodes that do not answer, whatever the machine has been through.
#include <doctest/doctest.h>

#include <algorithm>
#include <csignal>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/machine/machine.hpp"
#include "tests/host/machine/process_bench.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::test;

TEST_CASE("a silent node is told of after another watch, and after a restart") {
    for (const bool restarts : {false, true}) {
        Bench bench;
        bench.topology.heartbeat = {50, 20, 3};
        Machine machine(bench.topology, bench.options);
        std::vector<std::string> told;
        machine.tell_suspects([&told](const std::string& text) { told.push_back(text); });
        if (restarts) {
            machine.start_again({});
        } else {
            machine.watch(-1, {});
        }
        ::kill(pid_of(machine, "gp-0"), SIGSTOP);
        CHECK(end_of(machine).code == timeout_code);
        // A busy computer may delay other nodes, and gp-0 before, too.
        CHECK(std::ranges::count_if(told, [](const std::string& text) {
                  return text.starts_with("gp-0 (process ");
              }) >= 1);
    }
}
