#include <doctest/doctest.h>

#include <set>
#include <string>

#include "host/base/error.hpp"
#include "host/timing/counts/machine.hpp"

namespace pxpl5::host::timing {

namespace {

std::string refusal(const Topology& topology) {
    try {
        machine_of(topology);
    } catch (const RequestError& error) {
        CHECK(error.code == ExitCode::usage);
        return error.what();
    }
    return "no error";
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

TimingValue& entry(Topology& topology, std::string_view name) {
    for (TimingValue& value : topology.timing) {
        if (value.name == name) {
            return value;
        }
    }
    FAIL(std::string(name));
    return topology.timing.front();
}

}  // namespace

TEST_CASE("the modelled machine of the paper is what its file says") {
    const Machine machine = machine_of(load_topology("paper-1993"));
    CHECK(machine.gps == 36);
    CHECK(machine.renderers == 16);
    CHECK(machine.frame_buffers == 1);
    CHECK(machine.share == Sharing::even);
    CHECK(machine.assignment == Assignment::longest_first);
    CHECK(machine.gp_clock_mhz == 40);
    CHECK(machine.renderer_clock_mhz == 40);
    CHECK(machine.ring_channels == 8);
    CHECK(machine.ring_channel_mb_s == 80);
    CHECK(machine.ring_hop_ns == 50);
    CHECK(machine.frame_buffer_refresh_hz == 72);
}

TEST_CASE("every number of the machine is set by its own name, and nothing else is") {
    const Topology plain = load_topology("paper-1993");
    const Machine before = machine_of(plain);
    std::set<std::string_view> names;
    for (const Parameter& parameter : parameters()) {
        CAPTURE(std::string(parameter.name));
        CHECK(names.insert(parameter.name).second);
        const double other = before.*parameter.value == 1 ? 2 : 1;
        Topology changed = plain;
        apply_override(changed, std::string(parameter.name) + "=" + std::to_string(int(other)));
        const Machine after = machine_of(changed);
        for (const Parameter& each : parameters()) {
            CHECK(after.*each.value == (each.name == parameter.name ? other : before.*each.value));
        }
    }
    CHECK(names.size() == 21);
}

TEST_CASE("words are chosen by name") {
    const Machine own = machine_of(load_topology("paper-1993", {"share=own"}));
    CHECK(own.share == Sharing::own);
    CHECK(own.assignment == Assignment::longest_first);
    const auto assigned = [](const std::string& word) {
        return machine_of(load_topology("paper-1993", {"assignment=" + word})).assignment;
    };
    CHECK(assigned("first_free") == Assignment::first_free);
    CHECK(assigned("longest_first") == Assignment::longest_first);
    CHECK(assigned("round_robin") == Assignment::round_robin);
    CHECK(assigned("recorded") == Assignment::recorded);
}

TEST_CASE("a topology without timing has the paper's, with its own counts and ring") {
    Topology made;  // By hand: not even read from a file.
    made.gp.count = 5;
    made.renderer.count = 3;
    made.frame_buffer.count = 1;
    made.ring.channel_mb_s = 160;
    const Machine machine = machine_of(made);
    const Machine paper = machine_of(load_topology("paper-1993"));
    CHECK(machine.gps == 5);
    CHECK(machine.renderers == 3);
    CHECK(machine.ring_channel_mb_s == 160);
    CHECK(machine.gp_edge_cycles == paper.gp_edge_cycles);
    CHECK(machine.frames_in_flight == paper.frames_in_flight);
    CHECK(machine_of(load_topology("default")).host_link_mb_s == paper.host_link_mb_s);
}

TEST_CASE("a plan whose timing is not complete and right is refused by the parameter's name") {
    const Topology plain = load_topology("paper-1993");
    Topology wrong = plain;
    std::erase_if(wrong.timing, [](const TimingValue& v) { return v.name == "gp.edge_cycles"; });
    CHECK(refusal(wrong) == "paper-1993: section timing has no gp.edge_cycles");
    wrong = plain;
    wrong.timing.push_back(entry(wrong, "share"));
    CHECK(refusal(wrong) == "paper-1993: section timing has share 2 times");
    wrong = plain;
    entry(wrong, "gp.edge_cycles").name = "gp.egde_cycles";
    CHECK(
        has(refusal(wrong), "unknown parameter 'gp.egde_cycles'; did you mean 'gp.edge_cycles'?"));
    wrong = plain;
    entry(wrong, "gp.edge_cycles").unit = "us";
    CHECK(refusal(wrong) == "paper-1993: gp.edge_cycles is in 'us', must be in cycles");
    wrong = plain;
    entry(wrong, "gp.edge_cycles").value.reset();
    CHECK(has(refusal(wrong), "gp.edge_cycles has no value, must be a number of cycles"));
    wrong = plain;
    entry(wrong, "ring.channels").value = 8;
    CHECK(has(refusal(wrong), "ring.channels is 8 in section timing"));
    wrong = plain;
    entry(wrong, "share").value = 1;
    CHECK(has(refusal(wrong), "share is a word"));
}

}  // namespace pxpl5::host::timing
