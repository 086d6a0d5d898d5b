// Sessions on a simulated machine whose nodes die, stall and run out of memory, and whose messages
// are damaged, by a seed: each gives the pictures and numbers of an undisturbed one, or an error
// that names its cause.
// PXPL5_CHAOS_SEEDS is the number of seeds, PXPL5_CHAOS_FIRST the first one.
#include <doctest/doctest.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <new>
#include <random>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/text/picture_text.hpp"
#include "tests/random_seed.hpp"
#include "tests/system/mortal_machine.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using test::FailingAllocation;

[[gnu::noinline]] void* operator new(std::size_t bytes) {
    void* memory =
        FailingAllocation::fails() ? nullptr : std::malloc(std::max<std::size_t>(bytes, 1));
    if (memory == nullptr) {
        throw std::bad_alloc();
    }
    return memory;
}
[[gnu::noinline]] void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
    return FailingAllocation::fails() ? nullptr : std::malloc(std::max<std::size_t>(bytes, 1));
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
    std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, const std::nothrow_t&) noexcept {
    std::free(memory);
}

namespace {

constexpr int usual_seeds = test::seed_count(60);
constexpr std::uint64_t last_damaged = 400;  ///< Messages of a session, about.
constexpr int last_step = 1500;              ///< Steps of a session, about.
constexpr int most_restarts = 3;
constexpr std::uint64_t last_stall = 60, longest_stall = 400;  ///< Messages, and steps.

int number_from(const char* variable, int usual) {
    const char* text = std::getenv(variable);
    return text == nullptr ? usual : std::atoi(text);
}

using Chance = std::mt19937_64;
std::uint64_t below(Chance& chance, std::uint64_t end) {
    return chance() % end;
}

/// Commands of a session, whose answers do not depend on the machine.
std::vector<std::string> commands_of(Chance& chance) {
    static constexpr std::array choices = {"surface a iso=0.3 color=red",
                                           "surface b iso=0.6 opacity=0.5",
                                           "surface a visible=no",
                                           "surface a visible=yes",
                                           "view 30 20 zoom=1.5",
                                           "view 0 0 roll=10",
                                           "clip L 0",
                                           "clip off",
                                           "planes z=9 x=12",
                                           "planes off",
                                           "light 1 off",
                                           "background white",
                                           "antialias 4",
                                           "antialias 1",
                                           "components a show=largest",
                                           "certificate a",
                                           "compare a",
                                           "compare a off",
                                           "pick 30 30",
                                           "orbit 3",
                                           "sweep a 0.2 0.5 3",
                                           "undo",
                                           "digest"};
    std::vector<std::string> commands = {"size 80x64", "load phantom:sphere", "surface a iso=0.5"};
    for (int n = 0; n < 6; ++n) {
        commands.emplace_back(choices[below(chance, choices.size())]);
    }
    commands.emplace_back("load phantom:torus");
    commands.emplace_back("surface a iso=0.4");
    commands.emplace_back("digest");
    return commands;
}

/// The disturbances of a session.
struct Fate {
    std::vector<int> deaths;  ///< Steps of all pumps at which a node dies.
    std::vector<std::string> victims;
    int failing_launches = 0;
    test::Disturbance first;  ///< Disturbances of the first machine.
    std::uint64_t failing_allocation = FailingAllocation::never;  ///< Counted over all nodes.
};

Fate fate_of(Chance& chance, const Topology& topology) {
    Fate fate;
    for (std::uint64_t n = below(chance, 4); n > 0; --n) {
        const bool is_gp = below(chance, 2) == 0;
        const auto count =
            static_cast<std::uint64_t>(is_gp ? topology.gp.count : topology.renderer.count);
        fate.deaths.push_back(static_cast<int>(below(chance, last_step)));
        fate.victims.push_back((is_gp ? "gp-" : "renderer-") +
                               std::to_string(below(chance, count)));
    }
    fate.failing_launches = static_cast<int>(below(chance, 6) / 4);
    if (below(chance, 3) == 0) {
        fate.first.ring = {static_cast<bus::Damage>(1 + below(chance, 4)),
                           below(chance, last_damaged)};
    }
    const auto nodes = static_cast<std::uint64_t>(topology.gp.count + topology.renderer.count + 1);
    if (below(chance, 3) == 0) {
        fate.first.stall = {below(chance, nodes), below(chance, last_stall),
                            static_cast<int>(1 + below(chance, longest_stall))};
    }
    return fate;
}

Topology machine_of(Chance& chance) {
    Topology topology;
    topology.gp.count = 1 + static_cast<int>(below(chance, 4));
    topology.renderer.count = 1 + static_cast<int>(below(chance, 3));
    topology.frame_buffer.count = 1;
    topology.gp_memory_mib = 64;
    topology.seed = chance();
    const RestartSettings restart{
        below(chance, 3) == 0 ? RestartPolicy::degrade : RestartPolicy::replace, most_restarts, 0};
    topology.gp.restart = topology.renderer.restart = restart;
    return topology;
}

struct Outcome {
    std::vector<std::string> answers;  ///< Digests of pictures, and texts without times.
    std::string error;                 ///< The first one. Empty: all commands have answered.
    int launches = 0, restarts = 0, failures = 0;
    std::uint64_t allocations = 0;  ///< By nodes.
};

/// Calls `act`, and once more after an error about memory.
template <typename Act>
auto despite_memory(int& failures, const Act& act) {
    try {
        return act();
    } catch (const RequestError& error) {
        if (std::string_view(error.what()).find(bus::memory_exhausted) == std::string_view::npos) {
            throw;
        }
        ++failures;
        return act();
    }
}

/// The picture after a command, and what the command answers beside times.
///
/// failures  The number of commands that have failed for memory.
std::string answer_of(Session& session, const std::string& line, int& failures) {
    const Arguments arguments = parse_line(line);
    Reply reply;
    try {
        reply = despite_memory(failures, [&] { return run_command(session, arguments); });
    } catch (const RequestError& error) {
        if (error.code != ExitCode::usage) {
            throw;
        }
        return error.what();  // For example nothing to undo.
    }
    const bool has_numbers = arguments.name == "certificate" || arguments.name == "pick" ||
                             arguments.name == "digest" || arguments.name == "components";
    std::uint64_t digest = 0;
    if (session.volumes.has_volume()) {
        digest = despite_memory(failures, [&] {
            std::uint64_t drawn = 0;
            session.recovery.run([&] { drawn = picture_digest(session.frames.draw()); });
            return drawn;
        });
    }
    return std::to_string(digest) + (has_numbers ? " " + json_text(reply.fields) : "");
}

Outcome run_session(const std::vector<std::string>& commands, const Topology& topology,
                    const Fate& fate) {
    int extractions = 0, steps = 0, launches = 0;
    std::size_t deaths = 0;
    std::function<void()> during;
    const auto dies = [&]() -> std::optional<MachineError> {
        ++steps;
        if (deaths == fate.deaths.size() || steps < fate.deaths[deaths]) {
            return std::nullopt;
        }
        MachineError death(137, fate.victims[deaths] + " was killed by signal 9 (SIGKILL)");
        death.node = fate.victims[deaths++];
        return death;
    };
    const auto launch = [&] {
        ++launches;
        if (launches > 1 && launches <= 1 + fate.failing_launches) {
            throw MachineError(69, "no node can be started");
        }
        return launches == 1 ? fate.first : test::Disturbance{};
    };
    Outcome outcome;
    FailingAllocation::count_from_zero();  // None fails while the first machine starts.
    try {
        test::MortalMachine machine(topology, extractions, dies, during, launch);
        Session session(machine);
        session.scene.overlay = false;
        FailingAllocation::count_from_zero(fate.failing_allocation);
        for (const std::string& line : commands) {
            outcome.answers.push_back(answer_of(session, line, outcome.failures));
            outcome.restarts += static_cast<int>(session.recovery.take_restarts().size());
        }
    } catch (const RequestError& error) {
        outcome.error = error.what();
    } catch (const MachineError& error) {
        outcome.error = error.what();
    }
    outcome.allocations = FailingAllocation::counted();
    outcome.launches = launches;
    return outcome;
}

/// Whether a session may end with this error: damage of messages may fail any command.
bool is_lawful(const std::string& error, const Topology& topology, const Fate& fate) {
    const auto has = [&error](const char* part) { return error.find(part) != std::string::npos; };
    return fate.first.ring.damage != bus::Damage::none || has(" for this work; ") ||
           (topology.gp.restart.policy == RestartPolicy::degrade && has("it was the last "));
}

}  // namespace

TEST_CASE("deaths and damage change no picture and no number, or are named") {
    const int first = number_from("PXPL5_CHAOS_FIRST", 1);
    const int count = number_from("PXPL5_CHAOS_SEEDS", usual_seeds);
    int right = 0, named = 0, restarts = 0;
    for (int seed = first; seed < first + count; ++seed) {
        CAPTURE(seed);
        Chance chance(static_cast<std::uint64_t>(seed));
        const std::vector<std::string> commands = commands_of(chance);
        const Topology topology = machine_of(chance);
        Fate fate = fate_of(chance, topology);
        std::sort(fate.deaths.begin(), fate.deaths.end());
        const Outcome expected = run_session(commands, Topology(topology), {});
        REQUIRE_MESSAGE(expected.error.empty(), expected.error);
        REQUIRE(expected.restarts == 0);
        const Outcome outcome = run_session(commands, topology, fate);
        restarts += outcome.restarts;
        if (fate.deaths.empty() && fate.first.ring.damage == bus::Damage::none) {
            CHECK(outcome.restarts == 0);  // A stall alone costs time alone.
        }
        if (outcome.error.empty()) {
            ++right;
            CHECK(outcome.answers == expected.answers);
        } else {
            ++named;
            CHECK_MESSAGE(is_lawful(outcome.error, topology, fate), outcome.error);
            for (std::size_t n = 0; n < outcome.answers.size(); ++n) {
                CHECK_MESSAGE(outcome.answers[n] == expected.answers[n], commands[n]);
            }
        }
    }
    MESSAGE(right, " sessions right, ", named, " with a named error, ", restarts, " restarts");
    if (count >= usual_seeds) {
        CHECK(right > count / 2);
        CHECK(restarts > count / 2);
    }
}

TEST_CASE("a sweep leaves the surface as it was, whichever allocation fails") {
    Topology topology;
    topology.gp.count = topology.renderer.count = topology.frame_buffer.count = 1;
    topology.gp_memory_mib = 64;
    const std::vector<std::string> before = {"size 64x64", "load phantom:sphere",
                                             "surface a iso=0.3"};
    std::vector<std::string> commands = before;
    commands.emplace_back("sweep a 0.2 0.5 2");
    const Outcome expected = run_session(commands, topology, {});
    const std::uint64_t first = run_session(before, topology, {}).allocations;
    const std::uint64_t end = run_session(commands, topology, {}).allocations;  // Buffers are kept.
    REQUIRE(first + 100 < end);
    REQUIRE(expected.answers.back() == expected.answers[2]);
    int failures = 0;
    for (std::uint64_t failing = first; failing < end; failing += 7) {
        CAPTURE(failing);
        Fate fate;
        fate.failing_allocation = failing;
        const Outcome outcome = run_session(commands, topology, fate);
        CHECK(outcome.answers == expected.answers);
        failures += outcome.failures;
    }
    CHECK(failures > 50);
}

TEST_CASE("a surface that a GP has no memory for keeps its color") {
    const std::vector<std::string> commands = {"size 80x64", "load phantom:sphere",
                                               "surface a iso=0.5", "surface a iso=0.3 color=red",
                                               "undo"};
    Chance chance(1);
    const Topology topology = machine_of(chance);
    const Outcome expected = run_session(commands, topology, {});
    constexpr std::uint64_t places = 200;
    int failures = 0;
    for (std::uint64_t place = 0; place < places; ++place) {
        Fate fate;
        fate.failing_allocation = place * expected.allocations / places;
        CAPTURE(fate.failing_allocation);
        const Outcome outcome = run_session(commands, topology, fate);
        CHECK(outcome.answers == expected.answers);
        failures += outcome.failures;
    }
    CHECK(failures > 0);
}

TEST_CASE("a node that has no memory for its Topology is replaced once more") {
    const std::vector<std::string> commands = {"size 80x64", "load phantom:sphere",
                                               "surface a iso=0.5", "digest"};
    Topology topology;
    topology.gp.count = topology.renderer.count = 2;
    topology.frame_buffer.count = 1;
    topology.gp_memory_mib = 64;
    topology.gp.restart = {RestartPolicy::replace, most_restarts, 0};
    const Outcome expected = run_session(commands, topology, {});
    Fate fate;
    fate.deaths = {1};
    fate.victims = {"gp-1"};
    REQUIRE(run_session(commands, topology, fate).launches == 2);
    int third_launches = 0;
    for (std::uint64_t failing = 0; failing < 100; ++failing) {
        CAPTURE(failing);
        fate.failing_allocation = failing;
        const Outcome outcome = run_session(commands, topology, fate);
        CHECK(outcome.error.empty());
        CHECK(outcome.answers == expected.answers);
        third_launches += outcome.launches == 3 ? 1 : 0;
    }
    CHECK(third_launches > 5);
}

TEST_CASE(
    "a failed allocation in a node costs one command, which succeeds when it is given again") {
    const int first = number_from("PXPL5_CHAOS_FIRST", 1);
    const int count = number_from("PXPL5_CHAOS_SEEDS", usual_seeds);
    int failures = 0;
    for (int seed = first; seed < first + count; ++seed) {
        CAPTURE(seed);
        Chance chance(static_cast<std::uint64_t>(seed));
        const std::vector<std::string> commands = commands_of(chance);
        const Topology topology = machine_of(chance);
        const Outcome expected = run_session(commands, topology, {});
        REQUIRE_MESSAGE(expected.error.empty(), expected.error);
        Fate fate;
        fate.failing_allocation = below(chance, expected.allocations);
        CAPTURE(fate.failing_allocation);
        CAPTURE(fmt::format("{}", fmt::join(commands, "; ")));
        const Outcome outcome = run_session(commands, topology, fate);
        CHECK_MESSAGE(outcome.error.empty(), outcome.error);
        REQUIRE(outcome.answers.size() == expected.answers.size());
        for (std::size_t n = 0; n < commands.size(); ++n) {
            CHECK_MESSAGE(outcome.answers[n] == expected.answers[n], commands[n]);
        }
        failures += outcome.failures;
    }
    MESSAGE(failures, " of ", count, " sessions had a command that failed for memory");
    if (count >= usual_seeds) {
        CHECK(failures > count / 2);
    }
}
