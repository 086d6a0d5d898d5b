#include <doctest/doctest.h>
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <fstream>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "host/machine/heartbeat.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using bus::Body;
using bus::Phase;

namespace {

/// A heartbeat of 1 s, and the pulses of two nodes that the test writes itself.
struct Bench {
    explicit Bench(HeartbeatSettings settings = {1000, 5, 60}) : heartbeat(settings) {
        for (bus::PulseCell** cell : {&gp, &io}) {
            const std::string name = cell == &gp ? "gp-0" : "io-0";
            const int fd = dup(heartbeat.prepare(name));
            cells.push_back(std::make_unique<bus::PulseCell>(fd));
            *cell = cells.back().get();
            heartbeat.watch({name, 0, cell == &io}, now_ms);
            beat(**cell);
            step(**cell);
        }
        heartbeat.look(now_ms);
    }
    static void beat(bus::PulseCell& cell) { ++cell.words().beats; }
    static void step(bus::PulseCell& cell) { ++cell.words().progress; }
    void is_at(Phase phase, const bus::Doing& doing) const {
        bus::PulseWords& words = gp->words();
        words.work = static_cast<std::uint64_t>(doing.kind) |
                     static_cast<std::uint64_t>(phase) << 16 |
                     static_cast<std::uint64_t>(doing.subject) << 32;
        words.place = doing.done | static_cast<std::uint64_t>(doing.total) << 32;
    }
    /// Looks once a second. Both nodes beat and step unless the test says otherwise.
    std::vector<Heartbeat::Finding> pass(int seconds) {
        std::vector<Heartbeat::Finding> all;
        for (int i = 0; i < seconds; ++i) {
            now_ms += 1000;
            beat(*io);
            if (gp_beats) {
                beat(*gp);
            }
            if (io_steps) {
                step(*io);
            }
            if (gp_steps) {
                step(*gp);
            }
            for (const Heartbeat::Finding& found : heartbeat.look(now_ms)) {
                all.push_back(found);
            }
        }
        return all;
    }

    Heartbeat heartbeat;
    std::vector<std::unique_ptr<bus::PulseCell>> cells;
    bus::PulseCell *gp = nullptr, *io = nullptr;
    bool gp_beats = true, gp_steps = true, io_steps = true;
    std::int64_t now_ms = 5000;
};

/// The state of a thread of this process by the kernel: 'S' for one that sleeps.
char state_of_thread(int id) {
    std::ifstream file("/proc/self/task/" + std::to_string(id) + "/stat");
    std::string line;
    std::getline(file, line);
    return line.at(line.rfind(") ") + 2);
}

}  // namespace

TEST_CASE("a node that beats and moves is left alone") {
    Bench bench;
    CHECK(bench.pass(1000).empty());
}

TEST_CASE("time in which the beating thread waits for a processor counts a tenth") {
    Bench bench;
    const auto watch_again = [&](int beater) {
        bench.heartbeat.forget("gp-0");
        bench.cells.push_back(
            std::make_unique<bus::PulseCell>(dup(bench.heartbeat.prepare("gp-0"))));
        bench.gp = bench.cells.back().get();
        bench.gp->words().beater = beater;
        bench.heartbeat.watch({"gp-0", getpid(), false}, bench.now_ms);
        Bench::beat(*bench.gp);
        bench.pass(1);
    };
    bench.gp_beats = bench.gp_steps = false;
    watch_again(gettid());  // This thread runs while the heartbeat looks at it.
    CHECK(bench.pass(19).empty());
    const auto suspect = bench.pass(1);
    REQUIRE(suspect.size() == 1);
    CHECK_FALSE(suspect[0].is_dead);
    CHECK(bench.pass(29).empty());
    const auto dead = bench.pass(1);
    REQUIRE(dead.size() == 1);
    CHECK(dead[0].is_dead);

    std::array<int, 2> pipe_ends{};
    REQUIRE(pipe2(pipe_ends.data(), O_CLOEXEC) == 0);
    std::promise<int> id;
    const std::jthread sleeper([&id, input = pipe_ends[0]] {
        id.set_value(gettid());
        char none = 0;
        CHECK(read(input, &none, 1) == 0);  // Sleeps until the other end is closed.
        close(input);
    });
    const std::shared_ptr<void> closer(nullptr, [&](void*) { close(pipe_ends[1]); });
    const int sleeper_id = id.get_future().get();
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (state_of_thread(sleeper_id) != 'S') {
        REQUIRE(std::chrono::steady_clock::now() < deadline);
        std::this_thread::yield();
    }
    watch_again(sleeper_id);
    CHECK(bench.pass(1).empty());
    CHECK(bench.pass(1).size() == 1);
}

TEST_CASE("a silent node is suspect after two intervals and dead after the misses") {
    Bench bench;
    bench.heartbeat.name_surfaces([](std::uint32_t id) { return id == 7 ? "bone" : ""; });
    bench.is_at(Phase::working, {Body::SetSurface, 7, 2, 12});
    bench.gp_beats = bench.gp_steps = false;
    CHECK(bench.pass(1).empty());
    const auto suspect = bench.pass(3);
    REQUIRE(suspect.size() == 1);
    CHECK_FALSE(suspect[0].is_dead);
    CHECK(suspect[0].text ==
          "gp-0 (process 0) has not answered for 2.0 s while building surface 'bone' (slab 3 of "
          "12); it is ended after 5.0 s");
    const auto dead = bench.pass(10);
    REQUIRE(dead.size() == 1);
    CHECK(dead[0].is_dead);
    CHECK(dead[0].name == "gp-0");
    CHECK(dead[0].text ==
          "gp-0 (process 0) does not answer: last heard 5.0 s ago while building surface 'bone' "
          "(slab 3 of 12); the limit is 5.0 s (heartbeat.misses 5 of 1000 ms)");
}

TEST_CASE("a node that continues in time is suspect again only after a new silence") {
    Bench bench;
    for (int i = 0; i < 3; ++i) {
        bench.gp_beats = false;
        CHECK(bench.pass(4).size() == 1);
        bench.gp_beats = true;
        CHECK(bench.pass(4).empty());
    }
}

TEST_CASE("time in which the host was stopped does not count") {
    Bench bench;
    // The first look sees the nodes beat, the second sees one interval of silence.
    for (int i = 0; i < 2; ++i) {
        bench.now_ms += 3'600'000;
        CHECK(bench.heartbeat.look(bench.now_ms).empty());
    }
    bench.now_ms += 3'600'000;
    const auto findings = bench.heartbeat.look(bench.now_ms);
    REQUIRE(findings.size() == 2);
    CHECK_FALSE(findings[0].is_dead);
    CHECK_FALSE(findings[1].is_dead);
}

TEST_CASE("no node is ended if the heartbeat is off") {
    Bench bench({1000, 0, 60});
    bench.gp_beats = bench.gp_steps = false;
    CHECK(bench.pass(1000).empty());
    CHECK(bench.heartbeat.due_ms(bench.now_ms) == -1);
}

TEST_CASE("a node that beats but does not move is stuck after its limit, and not before") {
    Bench bench;
    bench.is_at(Phase::receiving, {Body::RegionPixels});
    bench.gp_steps = false;
    CHECK(bench.pass(59).empty());
    const auto stuck = bench.pass(100);
    REQUIRE(stuck.size() == 1);
    CHECK(stuck[0].is_dead);
    CHECK(stuck[0].text ==
          "gp-0 (process 0) is stuck: no progress for 60.0 s while it took "
          "RegionPixels; heartbeat.stuck_s is 60");
    Bench patient({1000, 5, 0});
    patient.gp_steps = false;
    CHECK(patient.pass(1000).empty());
}

TEST_CASE("an io process that computes without steps is not stuck") {
    Bench bench;
    bench.io_steps = false;
    for (int i = 0; i < 200; ++i) {
        bench.io->words().cpu_ns += 900'000'000;
        CHECK(bench.pass(1).empty());
    }
    CHECK(bench.pass(61).size() == 1);
}

TEST_CASE("an answer is lost if the host waits and no node has had work for the limit") {
    Bench bench;
    const auto wait = [&](int seconds) {
        for (int i = 0; i < seconds; ++i) {
            bench.heartbeat.note_wait();
            bench.pass(1);
        }
    };
    wait(4);
    CHECK(bench.heartbeat.is_suspicious());
    CHECK_FALSE(bench.heartbeat.is_lost());
    ++bench.gp->words().worked;
    wait(1);
    CHECK_FALSE_MESSAGE(bench.heartbeat.is_suspicious(), "a node works");
    bench.is_at(Phase::working, {Body::BeginFrame, 3});
    wait(20);
    CHECK_FALSE(bench.heartbeat.is_suspicious());
    bench.is_at(Phase::waiting, {});
    bench.pass(20);
    CHECK_FALSE_MESSAGE(bench.heartbeat.is_suspicious(), "the host waits for the user only");
    wait(4);
    bench.heartbeat.note_answer();
    wait(4);
    CHECK_FALSE(bench.heartbeat.is_lost());
    wait(1);
    CHECK(bench.heartbeat.is_lost());
}

TEST_CASE("the work of a node is put into words, also if the node writes nonsense") {
    const auto text = [](Phase phase, const bus::Doing& doing) {
        return work_text({.beats = 1, .phase = phase, .doing = doing}, {});
    };
    CHECK(text(Phase::waiting, {}) == "while it waited for messages");
    CHECK(text(Phase::working, {Body::RegionPrograms, 7, 2, 16}) ==
          "while drawing frame 7 (region 3 of 16)");
    CHECK(text(Phase::working, {Body::SetSurface, 3, 9, 9}) ==
          "while building surface 3 (slab 9 of 9)");
    CHECK(text(Phase::working, {Body::ImportVolume}) == "while reading a volume");
    CHECK(text(static_cast<Phase>(99), {Body::NONE}) == "while it waited for messages");
    CHECK(text(Phase::receiving, {Body::NONE}) == "while it took NONE");
}

TEST_CASE("the work of a process that waits within its work is told") {
    CHECK(work_text({.phase = Phase::waiting, .doing = {Body::Slices, 1, 4, 90}}, {}) ==
          "while storing or sending slices (slice 5 of 90), as it waited for messages");
    const auto text = [](Phase phase, Body kind) {
        return io_work_text({.beats = 1, .phase = phase, .doing = {kind}});
    };
    CHECK(text(Phase::waiting, Body::NONE) == "while it had no request");
    CHECK(text(Phase::working, Body::NONE) == "while it had no request");
    CHECK(text(Phase::receiving, Body::ImportVolume) == "while it took ImportVolume");
    CHECK(text(Phase::working, Body::ImportVolume) == "while reading a volume");
}
