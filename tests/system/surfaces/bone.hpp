// The bone of the built-in pelvis, in a session of its own on a simulated machine of its own.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/commands/commands.hpp"
#include "host/session/session.hpp"
#include "tests/system/machine_of.hpp"
#include "tests/system/simulated_machine.hpp"

namespace pxpl5::test {

struct Bone {
    /// slabs_per_set  Size of the slice sets of a GP; 0: as the machine chooses.
    explicit Bone(const host::Topology& topology, int slabs_per_set = 0)
        : machine(topology), session(machine) {
        session.load_settings.slabs_per_set = slabs_per_set;
        session.volumes.load("phantom:pelvis");
        session.scene.size = {200, 170};
        session.surfaces.set("bone", 250.5, CaseRule::watertight, {160, 160, 160});
    }
    host::Reply run(const std::string& line) {
        return host::run_command(session, host::parse_line(line));
    }
    /// The error of a line that is refused; empty if it is not.
    std::string refusal(const std::string& line) {
        try {
            run(line);
        } catch (const host::RequestError& error) {
            return error.what();
        }
        return {};
    }
    std::vector<std::uint32_t> draw() { return session.frames.draw().rgba.copy(); }
    double moved_mm() const { return session.frames.last().moved_mm; }

    SimulatedMachine machine;
    host::Session session;
};

}  // namespace pxpl5::test
