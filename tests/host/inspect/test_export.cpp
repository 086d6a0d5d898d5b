#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "host/inspect/listing/stream_files.hpp"
#include "host/inspect/listing/timeline.hpp"
#include "host/inspect/record/recorded_results.hpp"
#include "host/inspect/record/selected_messages.hpp"
#include "host/inspect/tools/program_files.hpp"
#include "isa/assemble.hpp"
#include "renderer_firmware/fast/fast.hpp"
#include "tests/host/inspect/recorded_sphere.hpp"
#include "tests/host/inspect/tool_files.hpp"

using namespace pxpl5;
using namespace pxpl5::host::inspect;
using Json = nlohmann::json;
using test::content_of;
using test::Folder;
namespace fs = std::filesystem;

namespace {

struct Drawn {
    Json json;
    TimelineCounts counts;
};
Drawn timeline_of(const RecordedRun& run, const SelectionText& selection,
                  std::uint64_t max_events) {
    const Folder folder;
    host::TextOutput output(folder.at("t.json"));
    const TimelineCounts counts = put_timeline(run, parse_selection(selection), max_events, output);
    output.finish();
    return {Json::parse(content_of(folder.at("t.json"))), counts};
}

}  // namespace

TEST_CASE("exported streams assemble to the recorded words and draw the recorded pixels") {
    const Folder folder;
    const RecordedRun run = test::TracedSphere({256, 128}, 3, 2).run();
    const StreamFiles written = write_streams(run, {}, folder.path);
    CHECK(written.regions == 2);
    const RecordedFrame frame = run.frame(0);
    for (const auto& [number, region] : frame.regions) {
        std::set<std::string> names;
        for (const auto& file : fs::directory_iterator(folder.path / "frame-0")) {
            const std::string name = file.path().filename().string();
            if (name.starts_with("region-" + std::to_string(number) + ".")) {
                names.insert(file.path().string());
            }
        }
        REQUIRE(names.size() == 3);
        CHECK(names.begin()->ends_with(".0.prologue.pxasm"));
        CHECK(names.rbegin()->ends_with(".2.end.pxasm"));
        std::vector<std::uint32_t> words, expected, pixels;
        renderer::fast::Fast executor;
        executor.set_readout(
            [&](std::span<const std::uint32_t> sent) { pixels.assign(sent.begin(), sent.end()); });
        isa::Controller controller;
        for (const std::string& name : names) {
            const auto program = assemble_file(name, content_of(name), {});
            words.insert(words.end(), program.begin(), program.end());
            isa::run(program, executor, controller);
        }
        for (const auto& part : region.plan.parts) {
            expected.insert(expected.end(), part.segment.words.begin(), part.segment.words.end());
        }
        CHECK(words == expected);
        const std::optional<RecordedTile> tile = tile_of(frame, number);
        REQUIRE(tile);
        CHECK(std::ranges::equal(pixels, tile->pixels));
    }
}

TEST_CASE("a segment that ends its stream, or branches, is a file of its own") {
    std::vector<NodeTrace> traces = test::TracedSphere({128, 128}, 1, 1).traces();
    const auto words = isa::assemble("NOP\nEOR\nNOP\nNOP\nLOOP #2\nENDLOOP\n").words;
    test::change<bus::schema::RegionPrograms>(traces, [&](bus::schema::RegionProgramsT& programs) {
        auto region = std::make_unique<bus::schema::RegionProgramT>();
        region->words = words;
        std::uint32_t first = 0, slab = 0;
        for (const std::uint32_t count : {1U, 1U, 1U, 1U, 2U}) {
            region->segments.emplace_back(0, slab++, first, count);
            first += count;
        }
        programs.regions.clear();
        programs.regions.push_back(std::move(region));
    });
    const Folder folder;
    // Prologue; NOP; EOR; NOP and NOP; the loop; end of region.
    CHECK(write_streams(RecordedRun(std::move(traces)), {}, folder.path).files == 6);
    CHECK(content_of(folder.at("frame-0/region-0.2.pxasm")).ends_with("\nEOR\n"));
}

TEST_CASE("a timeline holds every message, whole arrows, the frame and the modelled cycles") {
    const RecordedRun run = test::TracedSphere({256, 128}, 2, 2).run();
    const auto [json, counts] = timeline_of(run, {}, 1'000'000);
    std::size_t messages = 0, counted = 0;
    std::map<std::int64_t, double> begun;
    std::set<std::string> processes;
    std::string frame;
    double modelled_us = 0;
    for (const Json& event : json["traceEvents"]) {
        const std::string phase = event.at("ph");
        event.at("pid").get<int>();
        if (phase == "M") {
            if (event.at("name") == "process_name") {
                processes.insert(event["args"]["name"].get<std::string>());
            }
            continue;
        }
        ++counted;
        CHECK(event.at("ts").get<double>() >= 0);
        if (phase == "X") {
            CHECK(event.at("dur").get<double>() >= 0);
            messages += event["cat"] == "message" ? 1 : 0;
            modelled_us += event["args"].contains("cycles") ? event["dur"].get<double>() : 0;
        } else if (phase == "s") {
            begun[event.at("id")] = event["ts"];
        } else if (phase == "f") {
            REQUIRE(begun.count(event.at("id")) == 1);
            CHECK(begun[event["id"]] <= event["ts"].get<double>());
            begun.erase(event["id"].get<std::int64_t>());
        } else {
            frame += phase;
        }
    }
    CHECK(messages == select_messages(run, {}).size());
    CHECK(counted == counts.events);
    CHECK(begun.empty());
    CHECK(frame == "be");
    CHECK(processes == std::set<std::string>{"host", "gp-0", "gp-1", "renderer-0", "renderer-1",
                                             "framebuffer-0"});
    std::uint64_t cycles = 0;
    for (const auto& [number, region] : run.frame(0).regions) {
        cycles += tile_of(run.frame(0), number)->counts.cycles;
    }
    CHECK(modelled_us == doctest::Approx(static_cast<double>(cycles) / 40));
    CHECK(json["otherData"]["messages_left_out"] == 0);
}

TEST_CASE("slices of a track lie side by side or within each other, and none is lost") {
    test::RecordedMachine recorded(test::machine_of(2, 2));
    test::set_up_sphere(recorded.session, {256, 128});
    constexpr int frames = 5;
    recorded.session.frames.orbit(frames, [](int, const host::Picture&, const host::Camera&) {});
    std::vector<NodeTrace> traces = recorded.traces.traces();
    for (NodeTrace& node : traces) {  // Pixels that come late, while the next frame is fed.
        for (bus::trace::Entry& entry : node.entries) {
            entry.wall_ns += entry.kind() == bus::Body::RegionPixels ? 1'000'003 : 1;
        }
    }
    const RecordedRun run(std::move(traces));
    const auto [json, counts] = timeline_of(run, {}, 1'000'000);
    struct Slice {
        std::int64_t begin, end;
    };
    std::map<std::pair<int, int>, std::vector<Slice>> tracks;
    std::map<std::string, std::size_t> slices;
    const auto ns = [](const Json& us) {
        const double exact = us.get<double>() * 1000;
        CHECK(exact == doctest::Approx(std::round(exact)).epsilon(1e-12));
        return std::llround(exact);
    };
    for (const Json& event : json["traceEvents"]) {
        CHECK(event["pid"].get<int>() > 0);  // 0 is the idle process of Linux.
        if (event["ph"] == "X") {
            const std::int64_t begin = ns(event["ts"]);
            tracks[{event["pid"], event["tid"]}].push_back({begin, begin + ns(event["dur"])});
            const std::string name = event["name"];
            ++slices[event["cat"] == "message"                  ? "messages"
                     : name.find("region") != std::string::npos ? "regions"
                                                                : "draws"];
        }
    }
    for (auto& [track, all] : tracks) {
        CAPTURE(track.first);
        CAPTURE(track.second);
        std::ranges::sort(all, {}, [](const Slice& s) { return std::pair(s.begin, -s.end); });
        std::vector<Slice> open;
        for (const Slice& slice : all) {
            std::erase_if(open, [&](const Slice& outer) { return outer.end <= slice.begin; });
            CHECK((open.empty() || slice.end <= open.back().end));
            open.push_back(slice);
        }
    }
    CHECK(slices["messages"] == select_messages(run, {}).size());
    CHECK(slices["draws"] == frames * 2);
    CHECK(slices["regions"] == frames * 2);
    CHECK(counts.messages_left_out == 0);
}

TEST_CASE("a timeline keeps to its limit and says what it left out") {
    const RecordedRun run = test::TracedSphere({128, 128}, 2, 1).run();
    const std::size_t all = select_messages(run, {}).size();
    const auto [json, counts] = timeline_of(run, {}, 40);
    CHECK(counts.events <= 40);
    CHECK(counts.messages_left_out > 0);
    std::size_t messages = 0;
    for (const Json& event : json["traceEvents"]) {
        messages += event.value("cat", "") == "message" && event["ph"] == "X" ? 1 : 0;
    }
    CHECK(messages + counts.messages_left_out == all);
    CHECK(json["otherData"]["messages_left_out"] == counts.messages_left_out);
}

TEST_CASE("an arrow of the timeline leads from something older, at the sender") {
    // GPs receive everything before anybody else receives anything, so that the newest message at a
    // GP is not always the one that led to what it sent.
    std::vector<NodeTrace> traces = test::TracedSphere({256, 128}, 3, 2).traces();
    for (NodeTrace& node : traces) {
        for (bus::trace::Entry& entry : node.entries) {
            entry.wall_ns += node.info.role == bus::schema::Role::gp ? 0 : 1'000'000;
        }
    }
    const auto [json, counts] = timeline_of(RecordedRun(std::move(traces)), {}, 1'000'000);
    using Place = std::pair<int, double>;
    std::map<Place, std::pair<int, std::string>> slices;  // Logical time and sender.
    std::map<int, std::string> names;
    std::map<int, Place> begins;
    std::size_t arrows = 0;
    for (const Json& event : json["traceEvents"]) {
        const Place place(event["pid"], event.value("ts", 0.0));
        if (event["name"] == "process_name") {
            names[place.first] = event["args"]["name"];
        } else if (event["ph"] == "X" && event["cat"] == "message") {
            slices[place] = {event["args"]["clock"], event["args"]["from"]};
        } else if (event["ph"] == "s") {
            begins[event["id"]] = place;
        }
    }
    for (const Json& event : json["traceEvents"]) {
        if (event["ph"] == "f") {
            ++arrows;
            const Place from = begins.at(event["id"]);
            const auto& [clock, sender] = slices.at({event["pid"], event["ts"]});
            CHECK(names.at(from.first) == sender);
            CHECK(slices.at(from).first < clock);
        }
    }
    CHECK(arrows > 3 * 2);  // At least from BeginFrame to each GP's RegionPrograms.
}
