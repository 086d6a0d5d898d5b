#include <doctest/doctest.h>
#include <fmt/core.h>
#include <sched.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "host/base/error.hpp"
#include "host/machine/modelled_topology.hpp"
#include "host/machine/timing_section.hpp"
#include "host/machine/topology.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

constexpr const char* small = R"(
// Comments and unquoted keys are allowed.
{ roles: { gp: { count: 3, memory_mib: 8 }, renderer: { count: 5 } },
  ring: { transport: "tcp" } }
)";

/// The text of the error that `act` raises, which must be one of usage.
template <typename Act>
std::string refusal(const Act& act) {
    try {
        act();
    } catch (const RequestError& error) {
        CHECK(error.code == ExitCode::usage);
        return error.what();
    }
    return "no error";
}

std::string refusal_of(const std::string& text) {
    return refusal([&text] { parse_topology(text, "some/machine.json"); });
}

std::string refusal_of_override(const std::string& assignment) {
    return refusal([&assignment] { parse_topology(small, "small.json", {assignment}); });
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

int cores() {
    cpu_set_t set;
    sched_getaffinity(0, sizeof set, &set);
    return CPU_COUNT(&set);
}

}  // namespace

TEST_CASE("a topology file states the machine, and what it leaves out has the documented default") {
    const Topology plan = parse_topology(small, "folder/small.json");
    CHECK(plan.name == "small");
    CHECK(plan.gp.count == 3);
    CHECK(plan.gp_memory_mib == 8);
    CHECK(plan.renderer.count == 5);
    CHECK(plan.frame_buffer.count == 1);
    CHECK(plan.ring.transport == Transport::tcp);
    CHECK(plan.ring.channels == 8);
    CHECK(plan.ring.channel_mb_s == 80);
    CHECK(plan.ring.hop_ns == 50);
}

TEST_CASE("a count of 0 means as many as there are cores") {
    const Topology plan = load_topology("default");
    CHECK(plan.gp.count == cores());
    CHECK(plan.renderer.count == cores());
    CHECK(plan.frame_buffer.count == 1);
}

TEST_CASE("the machine of the paper has 36 GPs of 8 MiB, 16 Renderers and a frame buffer") {
    const Topology plan = load_topology("paper-1993");
    CHECK(plan.gp.count == 36);
    CHECK(plan.gp_memory_mib == 8);
    CHECK(plan.renderer.count == 16);
    CHECK(plan.frame_buffer.count == 1);
    CHECK(plan.ring.channels == 8);
    CHECK(plan.ring.channel_mb_s == 80);
}

TEST_CASE("the stereo machine is the paper's with a second frame buffer, timing included") {
    const Topology stereo = load_topology("paper-1993-stereo");
    CHECK(stereo.frame_buffer.count == 2);
    const auto text = [](Topology plan) {
        plan.name = "machine";
        plan.frame_buffer.count = 1;
        return resolved_json(plan);
    };
    CHECK(text(stereo) == text(load_topology("paper-1993")));
}

TEST_CASE("a known key in the wrong place is refused with the place where it belongs") {
    const std::string error = refusal_of(R"({"gp": {"count": 2}})");
    CHECK_MESSAGE(has(error, "unknown key 'gp'; it belongs in 'roles'"), error);
}

TEST_CASE("an unknown key is refused with file, line and the nearest key") {
    const std::string error = refusal_of("{\n  roles: {\n    gp: { cuont: 3 }\n  }\n}\n");
    CHECK_MESSAGE(error == "some/machine.json:3: unknown key 'cuont'; did you mean 'count'?",
                  error);
    const std::string role = refusal_of("{ roles: { renderers: { count: 3 } } }");
    CHECK_MESSAGE(
        has(role, "some/machine.json:1: unknown key 'renderers'; did you mean 'renderer'?"), role);
}

TEST_CASE("text that is not a topology is refused with file and line") {
    const std::string error = refusal_of("{\n  roles: {\n    gp: { count: \"many\" }\n  }\n}\n");
    CHECK_MESSAGE(has(error, "some/machine.json:3: "), error);
    CHECK_MESSAGE(has(refusal_of("{ roles: { "), "some/machine.json:1: "),
                  refusal_of("{ roles: { "));
    CHECK_MESSAGE(has(refusal_of(""), "some/machine.json:"), refusal_of(""));
}

TEST_CASE("a topology file is one JSON object: text of a schema is refused with its line") {
    for (const char* text : {"table A { x:string; } root_type A; { x: \"another root\" }",
                             "table A { x:int; }", "{}\n{}", "include \"other.fbs\"; {}"}) {
        const std::string error = refusal_of(text);
        CHECK_MESSAGE(has(error, "some/machine.json:"), error);
    }
    CHECK(refusal_of("{} // A comment behind it is no other text.") == "no error");
}

TEST_CASE("a value out of range is refused with the value and the range") {
    const std::string over = refusal_of("{ roles: { gp: { count: 65 }, renderer: { count: 1 } } }");
    CHECK_MESSAGE(over == "some/machine.json: gp.count is 65, must be 1..64", over);
    const std::string under = refusal_of("{ roles: { renderer: { count: -1 } } }");
    CHECK_MESSAGE(has(under, "renderer.count is -1, must be 1..64"), under);
    CHECK(has(refusal_of("{ roles: { frame_buffer: { count: 3 } } }"),
              "frame_buffer.count is 3, must be 1..2"));
    CHECK(has(refusal_of("{ ring: { transport: 7 } }"), "ring.transport is 7, must be ipc or tcp"));
    CHECK(has(refusal_of("{ record: 7 }"), "record is 7, must be off, flight or full"));
    CHECK(has(refusal_of("{ vector_target: 9 }"),
              "vector_target is 9, must be best, sse4, avx2 or avx512"));
    CHECK(has(refusal_of("{ roles: { gp: { env: [\"=x\"] } } }"), "gp.env has '=x'"));
    const std::string code = refusal_of("{ roles: { gp: { env: [\"LD_PRELOAD=/x.so\"] } } }");
    CHECK_MESSAGE(has(code, "gp.env sets 'LD_PRELOAD', but may set only names that begin with"),
                  code);
    CHECK(!has(code, "/x.so"));
    // Some libraries of OpenMP load what a variable names.
    CHECK(has(refusal_of("{ roles: { gp: { env: [\"OMP_TOOL_LIBRARIES=/x.so\"] } } }"),
              "gp.env sets 'OMP_TOOL_LIBRARIES'"));
    CHECK(has(refusal_of("{ roles: { gp: { cpu: [-1] } } }"), "gp.cpu names core -1"));
}

TEST_CASE("an override sets one value") {
    const Topology plan =
        parse_topology(small, "small.json",
                       {"gp.count=4", "gp.memory_mib=16", "gp.slabs_per_set=48",
                        "ring.transport=ipc", "seed=18446744073709551615", "renderer.cpu=0,1",
                        "frame_buffer.env=PXPL5_A=b=c", "record=full", "vector_target=avx2"});
    CHECK(plan.vector_target == VectorTarget::avx2);
    CHECK(plan.record == Recording::full);
    CHECK(plan.gp.count == 4);
    CHECK(plan.gp_memory_mib == 16);
    CHECK(plan.slabs_per_set == 48);
    CHECK(plan.ring.transport == Transport::ipc);
    CHECK(plan.seed == 18446744073709551615U);
    CHECK(plan.renderer.cpu == std::vector<int>{0, 1});
    CHECK(plan.frame_buffer.env == std::vector<std::string>{"PXPL5_A=b=c"});
    CHECK(parse_topology(small, "small.json", {"gp.count=0"}).gp.count == cores());
}

TEST_CASE("a modelled machine is not fitted to this computer's cores") {
    Topology plan = load_modelled_topology("paper-1993", {"gp.count=2"});
    CHECK_THROWS_WITH_AS(apply_modelled_override(plan, "gp.count=0"),
                         "--set gp.count=0: gp.count is 0, must be 1..1024", RequestError);
    CHECK_THROWS_AS(load_modelled_topology("paper-1993", {"renderer.count=0"}), RequestError);
}

TEST_CASE("a plan says how large it is, and whether this computer's cores decided that") {
    const std::string fitted = fmt::format("fitted to {} core{}", cores(), cores() == 1 ? "" : "s");
    CHECK(size_text(load_topology("paper-1993")) == "36 GPs, 16 Renderers");
    CHECK(size_text(load_topology("one-of-each")) == "1 GP, 1 Renderer");
    CHECK(has(size_text(load_topology("default")), fitted));
    CHECK(!has(size_text(load_topology("default", {"gp.count=3"})), "fitted"));
    CHECK(has(size_text(load_topology("paper-1993", {"renderer.count=0"})), fitted));
}

TEST_CASE("an override that cannot be obeyed names key, value and range") {
    CHECK(has(refusal_of_override("gp.count=65"), "gp.count is 65, must be 1..64"));
    CHECK(
        has(refusal_of_override("gp.cuont=5"), "unknown key 'gp.cuont'; did you mean 'gp.count'?"));
    CHECK(has(refusal_of_override("gp.count"), "must be key=value"));
    CHECK(has(refusal_of_override("gp.count=4x"), "gp.count is '4x', must be a whole number"));
    CHECK(has(refusal_of_override("ring.transport=udp"), "'udp', must be ipc or tcp"));
    CHECK(
        has(refusal_of_override("vector_target=mmx"), "'mmx', must be best, sse4, avx2 or avx512"));
    CHECK(has(refusal_of_override("record=on"), "record is 'on', must be off, flight or full"));
}

TEST_CASE("a plan without timing has that of the machine of the paper, and overrides change it") {
    const auto find = [](const Topology& plan, std::string_view name) {
        const TimingValue* found = find_timing(plan.timing, name);
        REQUIRE(found != nullptr);
        return *found;
    };
    const Topology paper = load_topology("paper-1993");
    const Topology plan = parse_topology(
        small, "small.json", {"gp.edge_cycles=17.5", "share=own", "ring.channel_mb_s=160"});
    CHECK(plan.timing.size() == paper.timing.size());
    CHECK(find(plan, "gp.edge_cycles").value == 17.5);
    CHECK(find(plan, "gp.edge_cycles").provenance == Provenance::ours);
    CHECK(find(plan, "share").word == "own");
    CHECK(plan.ring.channel_mb_s == 160);
    CHECK(!find(plan, "ring.channel_mb_s").value);
    CHECK(find(paper, "ring.channel_mb_s").provenance == Provenance::published);
    CHECK(find(plan, "ring.channel_mb_s").provenance == Provenance::ours);
    CHECK(find(plan, "gp.clock_mhz").value == find(paper, "gp.clock_mhz").value);
    CHECK(find(plan, "gp.clock_mhz").provenance == Provenance::published);
    CHECK(find(plan, "gp.clock_mhz").note == find(paper, "gp.clock_mhz").note);
}

TEST_CASE("every parameter of the machine of the paper says where it comes from") {
    for (const TimingValue& entry : load_topology("paper-1993").timing) {
        CHECK_MESSAGE(!entry.note.empty(), entry.name);
    }
    CHECK(enum_name(Provenance::published) == "published");
    CHECK(enum_name(Provenance::fitted) == "fitted");
}

TEST_CASE("a parameter of the timing that cannot be is refused by name, value and range") {
    const auto with = [](const std::string& entry) {
        return refusal_of("{ roles: { gp: { count: 1 }, renderer: { count: 1 } },\n  timing: [\n" +
                          entry + "] }");
    };
    CHECK(with("{ name: \"gp.edge_cycels\", value: 1, unit: \"cycles\", provenance: \"ours\" }") ==
          "some/machine.json:3: unknown parameter 'gp.edge_cycels'; did you mean "
          "'gp.edge_cycles'?");
    CHECK(with("{ name: \"gp.edge_cycles\", value: 1, unit: \"cycles\" }") ==
          "some/machine.json: gp.edge_cycles has no provenance");
    CHECK(with("{ name: \"gp.edge_cycles\", value: 1, unit: \"cycles\", provenance: 9 }") ==
          "some/machine.json: gp.edge_cycles's provenance is 9, must be published, recalled, "
          "derived, ours or fitted");
    CHECK(with("{ name: \"gp.edge_cycles\", value: 1, unit: \"cycles\", provenance: \"ours\" }") ==
          "some/machine.json: section timing has no host.link_mb_s");
    CHECK(has(refusal_of_override("gp.edge_cycles=-1"),
              "gp.edge_cycles is -1, must be 0..1000000 cycles"));
    CHECK(has(refusal_of_override("gp.edge_cycles=nan"), "gp.edge_cycles is nan, must be 0..1"));
    CHECK(has(refusal_of_override("gp.edge_cycles=1O"), "'1O', must be a number of cycles"));
    CHECK(has(refusal_of_override("ring.fifo_words=1.5"),
              "ring.fifo_words is 1.5, must be a whole number, 1..1000000 words"));
    CHECK(has(refusal_of_override("ring.channels=65"), "ring.channels is 65, must be 1..64"));
    CHECK(has(refusal_of_override("share=evne"), "share is 'evne', must be even or own"));
    CHECK(has(refusal_of_override("gp.edge_cycle=1"), "did you mean 'gp.edge_cycles'?"));
}

TEST_CASE("the resolved plan, read again, is the same plan") {
    const Topology plan = load_topology(
        "default",
        {"gp.cpu=0,1", "renderer.env=PXPL5_NAME=a \"quoted\" value", "gp.slabs_per_set=48",
         "seed=12345678901234567890", "ring.transport=tcp", "ring.hop_ns=0", "record=off",
         "vector_target=sse4", "gp.message_us=12.25", "assignment=recorded"});
    const std::string text = resolved_json(plan);
    const Topology again = parse_topology(text, "default.json");
    CHECK(resolved_json(again) == text);
    CHECK(again.gp.count == cores());
    CHECK(again.gp.cpu == plan.gp.cpu);
    CHECK(again.gp_memory_mib == plan.gp_memory_mib);
    CHECK(again.slabs_per_set == plan.slabs_per_set);
    CHECK(again.renderer.env == plan.renderer.env);
    CHECK(again.seed == plan.seed);
    CHECK(again.record == Recording::off);
    CHECK(again.vector_target == VectorTarget::sse4);
    CHECK(load_topology("default").record == Recording::flight);
    CHECK(again.ring.transport == Transport::tcp);
    CHECK(again.ring.hop_ns == 0);
    CHECK(find_timing(again.timing, "gp.message_us")->value == 12.25);
    CHECK(find_timing(again.timing, "assignment")->word == "recorded");
    CHECK(again.ring.channels == plan.ring.channels);
}

TEST_CASE("a machine is found by name or by path, and an unknown name lists the known ones") {
    const auto path = std::filesystem::temp_directory_path() /
                      ("pxpl5-topology-" + std::to_string(getpid()) + ".json");
    std::ofstream(path) << small;
    CHECK(load_topology(path.string()).renderer.count == 5);
    std::filesystem::remove(path);
    const std::string near = refusal([] { load_topology("paper-1992"); });
    CHECK_MESSAGE(near == "no topology 'paper-1992'; did you mean 'paper-1993'?", near);
    const std::string far = refusal([] { load_topology("x"); });
    CHECK_MESSAGE(has(far, "default, one-of-each, paper-1993, paper-1993-stereo"), far);
    CHECK(has(refusal([&path] { load_topology(path.string()); }), path.string()));
}

TEST_CASE("a file without a folder is named as such to whoever asks for a topology of its name") {
    const std::filesystem::path before = std::filesystem::current_path();
    const auto folder = before / ("pxpl5-topology-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder / "paper-1992");
    std::filesystem::current_path(folder);
    const std::string of_folder = refusal([] { load_topology("paper-1992"); });
    std::filesystem::remove("paper-1992");
    std::ofstream("paper-1992") << "text";
    const std::string of_file = refusal([] { load_topology("paper-1992"); });
    std::filesystem::current_path(before);
    std::filesystem::remove_all(folder);
    CHECK(of_folder == "no topology 'paper-1992'; did you mean 'paper-1993'?");
    CHECK(of_file ==
          "no topology 'paper-1992' (for the file, give ./paper-1992); did you mean "
          "'paper-1993'?");
}

TEST_CASE("the heartbeat has defaults, is read from files and overrides, and is written back") {
    const HeartbeatSettings usual = parse_topology(small, "small.json").heartbeat;
    CHECK(usual.interval_ms == 1000);
    CHECK(usual.misses == 10);
    CHECK(usual.stuck_s == 300);
    CHECK(usual.silence_ms() == 10'000);
    const Topology plan = parse_topology("{ heartbeat: { interval_ms: 200, misses: 0 } }", "a.json",
                                         {"gp.count=1", "renderer.count=1", "heartbeat.stuck_s=7"});
    const Topology again = parse_topology(resolved_json(plan), "b.json");
    CHECK(again.heartbeat.interval_ms == 200);
    CHECK(again.heartbeat.misses == 0);
    CHECK(again.heartbeat.stuck_s == 7);
    CHECK(has(refusal_of_override("heartbeat.misses=2"),
              "heartbeat.misses is 2, must be 0 (off) or at least 3"));
    CHECK(has(refusal_of_override("heartbeat.stuck_s=1"), "must be 0 (off) or at least 3"));
    CHECK(has(refusal_of_override("heartbeat.interval_ms=0"), "must be 10..60000"));
}
