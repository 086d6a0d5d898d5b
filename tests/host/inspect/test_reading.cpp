#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>
#include <utility>

#include "host/base/error.hpp"
#include "host/inspect/listing/enabled_pixels.hpp"
#include "host/inspect/listing/region_listing.hpp"
#include "host/inspect/listing/run_stats.hpp"
#include "host/inspect/record/find_run.hpp"
#include "host/inspect/record/message_text.hpp"
#include "host/inspect/record/run_table.hpp"
#include "host/inspect/record/selected_messages.hpp"
#include "host/inspect/tools/tools.hpp"
#include "isa/assemble.hpp"
#include "renderer_firmware/fast/fast.hpp"
#include "tests/host/inspect/recorded_sphere.hpp"
#include "tests/host/inspect/tool_files.hpp"

using namespace pxpl5;
using namespace pxpl5::host::inspect;
using test::content_of;
using test::Folder;
using test::selecting;
using Json = nlohmann::json;
namespace schema = bus::schema;
namespace fs = std::filesystem;

namespace {

/// A run of one GP and one region that holds nothing but this segment.
RecordedRun run_of(const std::vector<std::uint32_t>& words) {
    std::vector<NodeTrace> traces = test::TracedSphere({128, 128}, 1, 1).traces();
    test::change<schema::RegionPrograms>(traces, [&](schema::RegionProgramsT& programs) {
        auto region = std::make_unique<schema::RegionProgramT>();
        region->region = 0;
        region->words = words;
        region->segments = {schema::Segment(0, 4, 0, static_cast<std::uint32_t>(words.size()))};
        programs.regions.clear();
        programs.regions.push_back(std::move(region));
    });
    return RecordedRun(std::move(traces));
}

/// A triangle with edges of 24 bits, in the form that GPs write.
std::string triangle_text() {
    const std::string plane = " 1 2 3\n";
    std::string text = "SETENABS\n";
    for (int edge = 0; edge < 3; ++edge) {
        text += "TREEgeZERO :24" + plane;
    }
    return text + "TREEltMEM m8:24 >>8" + plane + "TREEintoMEM m8:24 >>8" + plane +
           "TREEintoMEM m32:10 >>16" + plane + "TREEintoMEM m42:10 >>16" + plane +
           "TREEintoMEM m52:10 >>16" + plane + "IMMintoMEM m0:8 #1\n";
}

PartCounts segment_of(const RunStats& stats) {
    for (const PartCounts& part : stats.parts) {
        if (part.is_segment()) {
            return part;
        }
    }
    FAIL("no segment");
    return {};
}

std::string listing_of(const RecordedRun& run, const Selection& selection,
                       std::optional<RegionPixel> pixel, std::uint64_t max_lines,
                       ListedLines* lines) {
    const Folder folder;
    const RecordedFrame frame = run.frame(0);
    host::TextOutput output(folder.at("listing"));
    *lines = list_region(frame, frame.regions.at(0), {selection, pixel, max_lines}, output);
    output.finish();
    return content_of(folder.at("listing"));
}

bool holds(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("k triangles are 10 k instructions, 34 k words and 256 k cycles") {
    constexpr std::uint64_t k = 7;
    std::string text;
    for (std::uint64_t i = 0; i < k; ++i) {
        text += triangle_text();
    }
    const RunStats stats = stats_of(run_of(isa::assemble(text).words), {});
    const PartCounts segment = segment_of(stats);
    // SETENABS 1; three edges n + 4; test and store of z b + n + 4; three normals; IMMintoMEM n
    // + 1.
    constexpr std::uint64_t cycles = 1 + 3 * (24 + 4) + 2 * (8 + 24 + 4) + 3 * (16 + 10 + 4) + 9;
    static_assert(cycles == 256);
    CHECK(segment.total() == OpCount{10 * k, cycles * k, 34 * k});
    CHECK(segment.primitives == k);
    const auto of = [&](isa::Op op) { return segment.ops[static_cast<std::size_t>(op)]; };
    CHECK(of(isa::Op::tree_ge_zero) == OpCount{3 * k, 3 * 28 * k, 12 * k});
    CHECK(of(isa::Op::tree_into_mem) == OpCount{4 * k, (36 + 90) * k, 16 * k});
    CHECK(of(isa::Op::imm_into_mem) == OpCount{k, 9 * k, k});
    // The Renderer told of the sphere that it drew in truth.
    CHECK(stats.differences.size() == 1);
}

TEST_CASE("a loop's body counts once as words and each time as instructions") {
    const RunStats stats = stats_of(run_of(isa::assemble("LOOP #3\nNOP\nENDLOOP\n").words), {});
    // LOOP 4 cycles, NOP 1, ENDLOOP 4.
    CHECK(segment_of(stats).total() == OpCount{1 + 3 + 3, 4 + 3 * 1 + 3 * 4, 3});
}

TEST_CASE("counts of a whole run equal what its Renderers told, and messages the machine's size") {
    const test::TracedSphere sphere({256, 128}, 2, 2);
    const RecordedRun run = sphere.run();
    const RunStats stats = stats_of(run, {});
    CHECK(stats.regions == 2);
    CHECK(stats.told == 2);
    CHECK(stats.differences.empty());
    const auto count = [&](bus::Body kind) {
        std::uint64_t messages = 0;
        for (const auto& [way, one] : stats.messages) {
            messages += way.kind == kind ? one.messages : 0;
        }
        return messages;
    };
    CHECK(count(bus::Body::RegionPrograms) == 2 * 2);  // Each GP to each Renderer.
    CHECK(count(bus::Body::RegionPixels) == 2);
    CHECK(count(bus::Body::BeginFrame) == 1 + 2 + 1);  // Other GPs, Renderers, frame buffer.
    CHECK(count(bus::Body::FrameDone) == 1);

    const RunStats part = stats_of(run, selecting({{&SelectionText::gp, {"1"}},
                                                   {&SelectionText::op, {"SETENABS"}},
                                                   {&SelectionText::kind, {"RegionPrograms"}}}));
    std::uint64_t primitives = 0;
    for (const PartCounts& one : part.parts) {
        CHECK((one.is_segment() && one.gp == 1));
        CHECK(one.total().instructions == one.primitives);
        primitives += one.primitives;
    }
    CHECK(primitives > 100);
    std::set<bus::NodeId> receivers;
    for (const auto& [way, one] : part.messages) {
        CHECK(one.messages == 1);
        receivers.insert(way.destination);
    }
    CHECK(receivers.size() == 2);  // GP 1 to both Renderers.
}

TEST_CASE("words on the ring are those of bodies and two of each header, by way and channel") {
    const test::TracedSphere sphere({256, 128}, 2, 2);
    std::vector<NodeTrace> traces = sphere.traces();
    using Way = std::tuple<bus::NodeId, bus::NodeId, std::uint16_t>;
    std::map<Way, std::uint64_t> expected;
    std::uint16_t channel = 0;
    for (NodeTrace& node : traces) {
        for (bus::trace::Entry& entry : node.entries) {
            const bus::schema::Header h = entry.header;
            channel = static_cast<std::uint16_t>((channel + 1) % 8);
            entry.header =
                bus::schema::Header(h.magic(), h.version(), h.kind(), h.source(), h.destination(),
                                    channel, h.reserved(), h.sequence(), h.body_bytes(),
                                    h.departure_ns(), h.arrival_ns(), h.clock());
            const auto body = static_cast<double>(node.load(entry).bytes().size());
            expected[{h.source(), h.destination(), channel}] +=
                2 + static_cast<std::uint64_t>(std::ceil(body / 4));
        }
    }
    std::map<Way, std::uint64_t> counted;
    for (const auto& [way, one] : stats_of(RecordedRun(traces), {}).messages) {
        counted[{way.source, way.destination, way.channel}] += one.words;
    }
    CHECK(counted == expected);
    CHECK(expected.size() > 16);
}

TEST_CASE("a listing shows how many pixels each instruction left enabled and what it wrote") {
    const RecordedRun run = run_of(isa::assemble("SETENABS\nTREEgeZERO :16 1 0 -64\n"
                                                 "CONSTintoMEM m88:8 5\n")
                                       .words);
    const Selection segments = selecting({{&SelectionText::gp, {"0"}}});
    ListedLines lines;
    const std::string first = listing_of(run, segments, std::nullopt, 100, &lines);
    CHECK(lines.listed == 3);
    CHECK(holds(first, "; primitive 0"));
    CHECK(holds(first, "16384 ->  8192"));  // x >= 64 is half of the region.
    CHECK(holds(first, "(64, 0) m88:8 0 -> 5"));
    CHECK(holds(first, "TREEgeZERO :16  1 0 -64"));
    CHECK_FALSE(holds(first, "prologue"));

    const std::string chosen = listing_of(run, segments, RegionPixel{10, 20}, 100, &lines);
    CHECK(holds(chosen, "Q = -54, is disabled"));
    CHECK(holds(chosen, "m88:8 0 (pixel disabled)"));
    const std::string inside = listing_of(run, segments, RegionPixel{100, 20}, 100, &lines);
    CHECK(holds(inside, "Q = 36, stays enabled"));
}

TEST_CASE("the value that a tree has at a pixel is A x + B y + C + D xx + E xy + F yy") {
    const std::int32_t k[] = {1, 2, 3, 4, 5, 6};
    CHECK(form_of({k, 3}, {7, 11}) == 7 + 22 + 3);
    CHECK(form_of(k, {7, 11}) == 7 + 22 + 3 + 4 * 49 + 5 * 77 + 6 * 121);
}

TEST_CASE("a listing counts what it leaves out") {
    const RecordedRun run = run_of(isa::assemble("SETENABS\nNOP\nNOP\nNOP\nNOP\n").words);
    ListedLines lines;
    listing_of(run, selecting({{&SelectionText::gp, {"0"}}}), std::nullopt, 2, &lines);
    CHECK(lines.listed == 2);
    CHECK(lines.left_out == 3);
    const std::string text =
        listing_of(run, selecting({{&SelectionText::gp, {"0"}}, {&SelectionText::op, {"NOP"}}}),
                   std::nullopt, 3, &lines);
    CHECK(lines.left_out == 1);
    CHECK_FALSE(holds(text, "SETENABS"));
}

TEST_CASE("the count and the first of enabled pixels are those of asking every pixel") {
    renderer::fast::Fast executor;
    CHECK(enabled_count(executor.pixels()) == 0);
    CHECK_FALSE(first_enabled(executor.pixels()).has_value());
    for (const auto& [a, b, c] : {std::tuple{3, -5, 77},
                                  {-1, -1, 9},
                                  {1, 1, -250},
                                  {-7, 2, 30},
                                  {0, 1, -127},
                                  {1, 64, -64 * 100 - 99}}) {
        const std::int32_t plane[] = {a, b, c};
        executor.execute({isa::Op::set_enabs, {}}, {});
        executor.execute({isa::Op::tree_ge_zero, {0, 0, 32}}, plane);
        std::size_t count = 0;
        std::optional<RegionPixel> first;
        for (int y = 0; y < 128; ++y) {
            for (int x = 0; x < 128; ++x) {
                const bool inside = a * x + b * y + c >= 0;
                first = inside && !first ? std::optional(RegionPixel{x, y}) : first;
                count += inside ? 1 : 0;
            }
        }
        CHECK(enabled_count(executor.pixels()) == count);
        CHECK(first_enabled(executor.pixels()) == first);
    }
}

TEST_CASE("a pixel that is enabled alone is the first and only one") {
    for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {14, 3}, {127, 7}, {0, 8}, {63, 127}}) {
        renderer::fast::Fast executor;
        executor.execute({isa::Op::set_enabs, {}}, {});
        const std::int32_t edges[][3] = {{1, 0, -x}, {-1, 0, x}, {0, 1, -y}, {0, -1, y}};
        for (const auto& edge : edges) {
            executor.execute({isa::Op::tree_ge_zero, {0, 0, 16}}, edge);
        }
        CHECK(enabled_count(executor.pixels()) == 1);
        CHECK(first_enabled(executor.pixels()) == std::optional(RegionPixel{x, y}));
    }
}

TEST_CASE("of two enabled pixels the first is the one in the upper row") {
    renderer::fast::Fast executor;  // Pixels are not stored row by row.
    executor.execute({isa::Op::set_enabs, {}}, {});
    const std::int32_t line[][3] = {{1, 4, -4}, {-1, -4, 4}};  // Through (0, 1) and (4, 0).
    for (const auto& edge : line) {
        executor.execute({isa::Op::tree_ge_zero, {0, 0, 16}}, edge);
    }
    CHECK(enabled_count(executor.pixels()) == 2);
    CHECK(first_enabled(executor.pixels()) == std::optional(RegionPixel{4, 0}));
}

TEST_CASE("the table of a run tells nodes, volume, and which regions can be executed") {
    const test::TracedSphere sphere({256, 128}, 2, 2);
    const RunTable table = table_of(sphere.run());
    CHECK(table.nodes.size() == 1 + 2 + 2 + 1);
    REQUIRE(table.volumes.size() == 1);
    CHECK(holds(table.volumes[0].name + table.volumes[0].source, "sphere"));
    REQUIRE(table.frames.size() == 1);
    CHECK(table.frames[0].regions == 2);
    CHECK(table.frames[0].executable == 2);
    CHECK(table.frames[0].done);
    CHECK(Json::parse(host::json_text(answer_of(table).fields()))["frames"][0]["width"] == 256);
}

TEST_CASE("a frame of two frame buffers is done when both have reported it") {
    host::Topology topology = test::machine_of(1, 1);
    topology.frame_buffer.count = 2;
    test::RecordedMachine recorded(topology);
    test::set_up_sphere(recorded.session, {100, 60});
    recorded.session.frames.draw();
    recorded.session.scene.stereo.mode = host::StereoMode::anaglyph;
    recorded.session.frames.draw();
    std::vector<NodeTrace> traces = recorded.traces.traces();
    const RunTable whole = table_of(RecordedRun(traces));
    REQUIRE(whole.frames.size() == 2);
    CHECK(whole.frames[0].done);
    CHECK(whole.frames[1].done);
    CHECK(whole.frames[1].instructions > whole.frames[0].instructions);
    CHECK(holds(answer_of(whole).text(), "\nmachine: GPs 1, Renderers 1, frame buffers 2"));
    std::erase_if(traces.front().entries, [&](const bus::trace::Entry& entry) {
        return entry.kind() == bus::Body::FrameDone &&
               entry.header.source() == recorded.machine.frame_buffer_ids().back();
    });
    const RunTable half = table_of(RecordedRun(traces));
    CHECK(half.frames[0].done);
    CHECK_FALSE(half.frames[1].done);
}

TEST_CASE("the text of a run tells the machine as far as its topology was recorded") {
    RunTable table;
    table.gps = 36;
    table.renderers = 16;
    CHECK(holds(answer_of(table).text(), "\nmachine: GPs 36, Renderers 16\n"));
    table.topology = R"({"roles": {"gp": {"memory_mib": 8}},
                         "ring": {"channels": 8, "channel_mb_s": 80}})";
    CHECK(holds(answer_of(table).text(), "; 8 MiB for each GP; ring of 8 channels of 80 MB/s\n"));
    table.topology = "{\"roles\": 3";
    CHECK(holds(answer_of(table).text(), "Renderers 16\n"));
}

TEST_CASE("a region cannot be executed without its Renderer's BeginFrame or any GP's programs") {
    const test::TracedSphere sphere({256, 128}, 2, 2);
    const auto executable_without = [&](const auto& is_lost) {
        std::vector<NodeTrace> traces = sphere.traces();
        for (NodeTrace& node : traces) {
            if (node.info.role == schema::Role::renderer && node.info.index == 1) {
                std::erase_if(node.entries, is_lost);
                node.cut = "at offset 77: cut off";
            }
        }
        const RunTable table = table_of(RecordedRun(std::move(traces)));
        CHECK(holds(answer_of(table).text(), "cut: at offset 77: cut off"));
        return table.frames.at(0).executable;
    };
    using bus::trace::Entry;
    CHECK(executable_without([](const Entry&) { return false; }) == 2);
    CHECK(executable_without([](const Entry& e) { return e.kind() == bus::Body::BeginFrame; }) ==
          1);
    bool first = true;
    CHECK(executable_without([&](const Entry& e) {
              return e.kind() == bus::Body::RegionPrograms && std::exchange(first, false);
          }) == 1);
}

TEST_CASE("messages come in the order of logical time, whoever received them") {
    const RecordedRun run = test::TracedSphere({128, 128}, 2, 1).run();
    const std::vector<MessageRef> all = select_messages(run, {});
    std::size_t entries = 0;
    for (const auto& [id, node] : run.nodes()) {
        entries += node.entries.size();
    }
    CHECK(all.size() == entries);
    for (std::size_t i = 1; i < all.size(); ++i) {
        REQUIRE(all[i - 1].header().clock() <= all[i].header().clock());
    }
    for (const MessageRef& one : select_messages(run, selecting({{&SelectionText::gp, {"1"}}}))) {
        const bool to = run.node_name(one.header().destination()) == "gp-1";
        CHECK((to || run.node_name(one.header().source()) == "gp-1"));
    }
    const auto of_frame = select_messages(run, selecting({{&SelectionText::frame, {"0"}}}));
    REQUIRE_FALSE(of_frame.empty());
    CHECK(of_frame.size() < all.size());
    CHECK(of_frame.front().at().kind() == bus::Body::DrawFrame);
    CHECK(holds(message_line(run, of_frame.front(), start_of(run)), "frame 0: 128 x 128, 1 view"));
    CHECK(select_messages(run, selecting({{&SelectionText::frame, {"9"}}})).empty());
}

TEST_CASE("the newest run that holds a trace is found, and none is refused") {
    const Folder folder;
    CHECK_THROWS_WITH_AS(find_run("", folder.path), doctest::Contains("no recorded run"),
                         host::RequestError);
    const auto now = fs::file_time_type::clock::now();
    for (const auto& [name, age_h] : {std::pair{"b", 1}, {"a", 3}, {"c", 2}}) {
        fs::create_directories(folder.path / name / "traces");
        std::ofstream(folder.path / name / "traces" / "host.mcap") << "x";
        fs::last_write_time(folder.path / name / "traces", now - std::chrono::hours(age_h));
    }
    for (const char* name : {"a", "b", "c"}) {
        fs::last_write_time(folder.path / name, now - std::chrono::hours(5));
    }
    CHECK(find_run("latest", folder.path) == folder.path / "b");
    CHECK(find_run("latest-recorded", folder.path) == folder.path / "b");
    // A newer run without a trace is never passed over in silence.
    fs::create_directories(folder.path / "d" / "traces");
    CHECK(find_run("latest-recorded", folder.path) == folder.path / "b");
    for (const char* text : {"", "latest"}) {
        CHECK_THROWS_WITH_AS(find_run(text, folder.path), doctest::Contains("latest-recorded"),
                             host::RequestError);
    }
    CHECK(find_run("some/where", folder.path) == "some/where");
}
