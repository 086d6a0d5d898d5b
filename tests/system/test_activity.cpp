// Tests the nodes' reports against the known work of a frame.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "host/commands/text/activity_text.hpp"
#include "host/session/activity/network.hpp"
#include "host/session/session.hpp"
#include "tests/system/error_of.hpp"
#include "tests/system/simulated_machine.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
namespace schema = bus::schema;

namespace {

constexpr int frames = 5;
constexpr int columns = 3, rows = 2;

Topology machine_of(int gps, int renderers) {
    Topology topology;
    topology.gp.count = gps;
    topology.renderer.count = renderers;
    topology.frame_buffer.count = 1;
    topology.seed = 11;
    return topology;
}

/// A session that shows a sphere in columns x rows regions.
struct Bench {
    test::SimulatedMachine machine;
    Session session{machine};

    Bench(int gps, int renderers) : machine(machine_of(gps, renderers)) {
        session.volumes.load("phantom:sphere");
        session.scene.size = {columns * 128 - 50, rows * 128};
        session.surfaces.set("s", 0.5, CaseRule::watertight, {160, 160, 160});
    }
    void draw_frames() {
        for (int i = 0; i < frames; ++i) {
            session.scene.camera.angles.azimuth_deg = 10.0 * i;
            session.frames.draw();
        }
    }
};

/// Messages of `kind` that a node has sent to any node, or to one.
std::uint64_t sent(const NodeReport& report, bus::Body kind,
                   std::optional<bus::NodeId> to = std::nullopt) {
    std::uint64_t count = 0;
    for (const bus::SentCount& each : report.sent) {
        count += each.kind == kind && (!to || each.to == *to) ? each.messages : 0;
    }
    return count;
}

std::int64_t began(const NodeReport& report, const std::string& stage) {
    for (const NodeReport::Stage& each : report.stages) {
        if (each.name == stage) {
            return each.count;
        }
    }
    return 0;
}

const NodeReport& of(const ActivityReport& report, const std::string& name) {
    const auto found = std::ranges::find_if(
        report.nodes, [&](const NodeReport& node) { return node.node.name == name; });
    REQUIRE(found != report.nodes.end());
    return *found;
}

FieldValue value_of(const Fields& fields, const std::string& name) {
    const auto found = std::ranges::find(fields, name, &Field::name);
    REQUIRE(found != fields.end());
    return found->value;
}

}  // namespace

TEST_CASE("every node's counts are those of the frames that were drawn, on every machine") {
    for (const auto& [gps, renderers] : {std::pair(1, 1), {2, 2}, {5, 3}, {36, 16}}) {
        CAPTURE(gps);
        CAPTURE(renderers);
        Bench bench(gps, renderers);
        bench.session.nodes.activity(AwaitAnswers::all);
        bench.draw_frames();
        const ActivityReport report = bench.session.nodes.activity(AwaitAnswers::all);
        CHECK(report.frames == frames);
        REQUIRE(report.nodes.size() == static_cast<std::size_t>(1 + gps + renderers + 1));
        std::int64_t regions = 0;
        std::uint64_t all_sent = 0, all_received = 0;
        for (const NodeReport& node : report.nodes) {
            CAPTURE(node.node.name);
            CHECK(node.answered);
            for (const bus::SentCount& each : node.sent) {
                all_sent += each.messages;
            }
            all_received += node.received_messages;
            if (node.node.role == schema::Role::host) {
                CHECK(sent(node, bus::Body::DrawFrame) == frames);
                continue;
            }
            CHECK(node.frames == frames);
            CHECK(node.busy_ms > 0);
            CHECK(node.busy_ms <= node.wall_ms);
            CHECK(node.queue == 0);
            if (node.node.role == schema::Role::gp) {
                for (const bus::NodeId renderer : bench.machine.renderer_ids()) {
                    CHECK(sent(node, bus::Body::RegionPrograms, renderer) == frames);
                }
                CHECK(node.memory_bytes > 0);
            } else if (node.node.role == schema::Role::renderer) {
                regions += began(node, "end_of_region");
                CHECK(sent(node, bus::Body::RegionPixels) == frames);
            } else {
                CHECK(began(node, "assemble") == frames * renderers);
                CHECK(sent(node, bus::Body::FrameDone, bus::host_id) == frames);
            }
        }
        CHECK(regions == frames * columns * rows);
        // The Master begins a frame at all others that draw.
        CHECK(sent(of(report, "gp-0"), bus::Body::BeginFrame) ==
              static_cast<std::uint64_t>(frames * (gps - 1 + renderers + 1)));
        CHECK(all_sent == all_received);
    }
}

TEST_CASE("messages are seen on all channels that the model gave them") {
    std::map<std::uint16_t, std::uint64_t> given;
    bool counting = false;
    test::SimulatedMachine machine(machine_of(4, 4), {}, [&](bus::NodeId, const bus::Message& m) {
        if (counting && !bus::is_onlookers(m.kind())) {
            ++given[m.header().channel()];
        }
    });
    Session session(machine);
    session.volumes.load("phantom:sphere");
    session.nodes.activity(AwaitAnswers::all);
    counting = true;
    session.surfaces.set("s", 0.5, CaseRule::watertight, {160, 160, 160});
    session.frames.draw();
    const ActivityReport report = session.nodes.activity(AwaitAnswers::all);
    std::map<std::uint16_t, std::uint64_t> counted;
    for (const NodeReport& node : report.nodes) {
        for (const bus::SentCount& each : node.sent) {
            counted[each.channel] += each.messages;
        }
    }
    CHECK(counted == given);
    CHECK(counted.size() == 8);
}

TEST_CASE("what is reported once is not reported again, and what the stages took is all there is") {
    Bench bench(2, 2);
    bench.draw_frames();
    const ActivityReport first = bench.session.nodes.activity(AwaitAnswers::all);
    CHECK(of(first, "gp-1").frames == frames);
    CHECK(began(of(first, "gp-1"), "extract") > 0);
    const ActivityReport second = bench.session.nodes.activity(AwaitAnswers::all);
    for (const NodeReport& node : second.nodes) {
        CAPTURE(node.node.name);
        CHECK(node.sent.empty());
        CHECK(node.frames == 0);
        CHECK(node.received_messages == 0);
        CHECK(node.wall_ms >= 0);
    }
    CHECK(second.frames == 0);
    CHECK(began(of(second, "gp-1"), "extract") == 0);
    CHECK(of(second, "gp-1").memory_bytes == of(first, "gp-1").memory_bytes);
}

TEST_CASE("without waiting, activity has the answers so far and names the missing nodes") {
    Bench bench(2, 1);
    const ActivityReport first = bench.session.nodes.activity(AwaitAnswers::none);
    // One step of the ring brings a question to its node, and no answer.
    CHECK(!of(first, "gp-0").answered);
    CHECK(of(first, "host").answered);
    bench.draw_frames();  // The answers come meanwhile.
    const ActivityReport second = bench.session.nodes.activity(AwaitAnswers::none);
    for (const NodeReport& node : second.nodes) {
        CHECK(node.answered);
    }
}

TEST_CASE("looking changes no picture") {
    Bench looked_at(3, 2), alone(3, 2);
    for (int i = 0; i < 3; ++i) {
        looked_at.session.nodes.activity(AwaitAnswers::none);
        CHECK(looked_at.session.frames.draw().rgba == alone.session.frames.draw().rgba);
    }
}

TEST_CASE("programs are told the last frame's regions and all nodes in ring order") {
    Bench bench(2, 2);
    bench.session.frames.draw();
    const ActivityReport report = bench.session.nodes.activity(AwaitAnswers::all);
    const FrameReport& frame = bench.session.frames.last();
    CHECK(frame.region_columns == columns);
    CHECK(frame.region_rows == rows);
    CHECK(frame.region_cycles.size() == columns * rows);
    REQUIRE(frame.region_renderers.size() == columns * rows);
    std::array<std::uint64_t, 2> cycles{};  // Of each Renderer.
    for (std::size_t region = 0; region < frame.region_cycles.size(); ++region) {
        cycles.at(frame.region_renderers[region]) += frame.region_cycles[region];
    }
    const auto told = std::get<Fields>(value_of(activity_fields(report, frame), "frame"));
    CHECK(std::get<double>(value_of(told, "renderer_ms_1993")) ==
          static_cast<double>(std::max(cycles[0], cycles[1])) / 40'000);
    const std::string json = json_text(activity_fields(report, frame));
    CHECK(json.find(R"("columns":3,"rows":2)") != std::string::npos);
    std::size_t at = 0;
    for (const char* name : {"host", "gp-0", "gp-1", "renderer-0", "renderer-1", "framebuffer-0"}) {
        at = json.find(fmt::format(R"("name":"{}","role")", name), at);
        CHECK(at != std::string::npos);
    }
    CHECK(json.find(R"("to":"renderer-1","kind":"RegionPrograms")") != std::string::npos);
}

TEST_CASE("what cannot be killed is refused by name") {
    Bench bench(2, 1);
    CHECK(test::error_of([&] {
              bench.session.nodes.kill("gp-7");
          }).find("there is no node 'gp-7'; did") == 0);
    CHECK(test::error_of([&] { bench.session.nodes.kill("host"); }).find("host cannot be killed") ==
          0);
    CHECK(test::error_of([&] { bench.session.nodes.kill("io-0"); }).find("io-0 cannot be killed") ==
          0);
    CHECK(test::error_of([&] { bench.session.nodes.kill("gp-1"); }) ==
          "this machine has no processes to kill");
}

TEST_CASE("a fault that comes unasked is told where it is taken, and not by the next request") {
    Bench bench(2, 1);
    bench.machine.send(bench.machine.gp_ids().front(), bus::pack(schema::SlicesT{}));
    std::string told;
    for (int look = 0; look < 100 && told.empty(); ++look) {  // Each look delivers a little.
        told = test::error_of([&] { bench.session.nodes.activity(AwaitAnswers::none); });
    }
    CHECK(told.find("background request: ") == 0);
    CAPTURE(told);
    CHECK(told.find("slice_count is 0") != std::string::npos);
    CHECK(test::error_of([&] { bench.session.frames.draw(); }).empty());
    CHECK(test::error_of([&] { bench.session.nodes.activity(AwaitAnswers::all); }).empty());
}

TEST_CASE("activities that arrive while a volume is given up are not lost") {
    Bench bench(2, 1);
    bench.session.nodes.activity(AwaitAnswers::none);  // Asks, and leaves the answers under way.
    bench.session.load_settings.progress = [](const LoadProgress& now) {
        if (now.phase == LoadProgress::Phase::distributing) {
            throw RequestError(ExitCode::failed, "given up");
        }
    };
    CHECK(test::error_of([&] { bench.session.volumes.load("phantom:sphere"); }) == "given up");
    bench.session.load_settings.progress = nullptr;
    CHECK(test::error_of([&] { bench.session.nodes.activity(AwaitAnswers::all); }).empty());
}

TEST_CASE("bytes between computers are those of messages that leave a computer") {
    const MachineNode host{0, schema::Role::host, "host", "login", 0};
    const MachineNode gp{1, schema::Role::gp, "gp-0", "n1", 1};
    const MachineNode renderer{2, schema::Role::renderer, "renderer-0", "n1", 1};
    const MachineNode buffer{3, schema::Role::frame_buffer, "framebuffer-0", "login", 0};
    ActivityReport report{.frames = 10, .nodes = {}};
    for (const MachineNode& node : {host, gp, renderer, buffer}) {
        report.nodes.push_back({.node = node, .answered = true, .cpu_ms = 2});
    }
    CHECK(activity_text(report).find("nodes    cpu ms") != std::string::npos);
    report.nodes[1].sent = {{2, bus::Body::RegionPrograms, 0, 10, 7000}};
    report.nodes[2].sent = {{3, bus::Body::RegionPixels, 0, 10, 4000},
                            {1, bus::Body::Credit, 0, 1, 50}};
    report.nodes[0].sent = {{1, bus::Body::DrawFrame, 0, 10, 1000},
                            {900, bus::Body::ImportVolume, 0, 1, 70}};
    const NetworkReport network = network_of(report);
    CHECK(network.bytes == 5000);
    REQUIRE(network.computers.size() == 2);
    CHECK(network.computers[0].name == "login");
    CHECK(network.computers[0].nodes == 2);
    CHECK(network.computers[0].cpu_ms == 4);
    CHECK(network.computers[0].sent_bytes == 1000);
    CHECK(network.computers[0].received_bytes == 4000);
    CHECK(network.computers[1].sent_bytes == 4000);
    REQUIRE(network.kinds.size() == 2);
    CHECK(network.kinds[0].kind == bus::Body::RegionPixels);
    CHECK(activity_text(report).ends_with(
        "between computers: 0.005 MB, 0.001 MB a frame; RegionPixels 0.004, DrawFrame 0.001"));
    const Fields fields = activity_fields(report, {});
    const auto sums = std::get<Fields>(value_of(fields, "network"));
    CHECK(std::get<double>(value_of(sums, "bytes_per_frame")) == 500);
    // On one computer there is nothing to say.
    for (NodeReport& node : report.nodes) {
        node.node.computer.clear();
    }
    CHECK(activity_text(report).find("computer") == std::string::npos);
}
