// A host that launches a machine, prints "<pid> <name>" of every node and "ready", and waits.
// usage: idle_host BINARIES RUN_BASE TOPOLOGY [key=value...]
#include <cstdio>
#include <string>
#include <vector>

#include "host/machine/machine.hpp"

int main(int argc, char** argv) {
    using namespace pxpl5::host;
    if (argc < 4) {
        return 64;
    }
    try {
        MachineOptions options;
        options.binaries = argv[1];
        options.run_base = argv[2];
        // Nodes may stay idle for ever although the host waits.
        std::vector<std::string> overrides = {"heartbeat.misses=0"};
        overrides.insert(overrides.end(), argv + 4, argv + argc);
        Machine machine(load_topology(argv[3], overrides), options);
        for (const Machine::Process& process : machine.processes()) {
            std::printf("%d %s\n", process.pid, process.name.c_str());
        }
        std::puts("ready");
        std::fflush(stdout);
        machine.pump([](const pxpl5::bus::Message&) {}, [] { return false; });
    } catch (const MachineError& error) {
        std::fprintf(stderr, "error: %s\n", error.what());
        return error.code;
    }
}
