// Recorded runs of formally valid messages that no machine sends: each question gets an answer or
// an error.
#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/inspect/map/map_values.hpp"
#include "host/inspect/model/recorded_work.hpp"
#include "host/inspect/record/run_table.hpp"
#include "host/inspect/replay/executors.hpp"
#include "host/inspect/replay/replay.hpp"
#include "host/inspect/why/why_not.hpp"
#include "host/phantom/phantom.hpp"
#include "isa/assemble.hpp"
#include "isa/reference/reference.hpp"
#include "tests/host/inspect/recorded_sphere.hpp"
#include "tests/host/inspect/recorded_surface.hpp"
#include "tests/random_seed.hpp"
#include "tests/system/error_of.hpp"

using namespace pxpl5;
using namespace pxpl5::test;
namespace inspect = host::inspect;
namespace schema = bus::schema;
using Traces = std::vector<inspect::NodeTrace>;

namespace {

constexpr int center_px = 64;

Traces sphere_traces(int samples = 1) {
    RecordedMachine recorded(machine_of(2, 2));
    set_up_sphere(recorded.session, {2 * center_px, 2 * center_px});
    if (samples == 1) {
        recorded.session.frames.draw();
    } else {
        recorded.session.frames.draw_samples(samples);
    }
    return recorded.traces.traces();
}

inspect::WhyFinding why_center(const inspect::RecordedRun& run) {
    inspect::FrameInquiry frame(run, std::nullopt);
    return inspect::why(frame, center_px, center_px);
}

/// Why the voxels of the triangle at the center are not known.
std::string unknown_at_center(const Traces& traces) {
    const inspect::RecordedRun run(traces);
    const inspect::WhyFinding finding = why_center(run);
    REQUIRE(finding.shown() != nullptr);
    return finding.shown()->cell.value().unknown;
}

/// The message that changed() gives instead, if it is valid.
std::optional<bus::Message> mutated(const bus::Message& message, std::mt19937_64& random) {
    const auto bytes = message.bytes();
    const auto words = std::make_shared<std::vector<std::uint64_t>>((bytes.size() + 7) / 8);
    auto* copy = reinterpret_cast<std::uint8_t*>(words->data());
    std::memcpy(copy, bytes.data(), bytes.size());
    constexpr std::array<std::uint64_t, 8> values = {0,      1,           2,           0x7FFF,
                                                     0xFFFF, 0x4000'0000, 0x7FFF'FFFF, 0xFFFF'FFFF};
    for (std::uint64_t n = random() % 4 + 1; n > 0; --n) {
        const std::size_t width = std::size_t{1} << random() % 3;
        const std::size_t at = random() % (bytes.size() / width) * width;
        const std::uint64_t value = random() % 4 == 0 ? random() : values[random() % values.size()];
        std::memcpy(copy + at, &value, width);
    }
    try {
        return bus::Message(message.header(), {copy, bytes.size()}, words);
    } catch (const bus::BadMessage&) {
        return std::nullopt;
    }
}

/// Every message is replaced by a mutated one with a chance of 1 to `rarity`.
Traces mutated(const Traces& traces, std::uint64_t rarity, std::mt19937_64& random) {
    Traces all = traces;
    for (inspect::NodeTrace& node : all) {
        auto changed = std::make_shared<std::vector<bus::Message>>();
        for (bus::trace::Entry& entry : node.entries) {
            bus::Message message = node.load(entry);
            for (int tries = 0; random() % rarity == 0 && tries < 50; ++tries) {
                if (auto other = mutated(message, random)) {
                    message = *std::move(other);
                    break;
                }
            }
            entry.offset = changed->size();
            changed->push_back(message);
        }
        node.load = [changed](const bus::trace::Entry& entry) { return changed->at(entry.offset); };
    }
    return all;
}

/// Calls ask(); an error that names what is wrong is an answer, too.
template <typename Ask>
void answered(const Ask& ask) {
    try {
        ask();
    } catch (const host::RequestError& error) {
        CHECK(!std::string(error.what()).empty());
    } catch (const std::logic_error& error) {  // What the firmware throws for bad parameters.
        CHECK(!std::string(error.what()).empty());
    }
}

void ask_all(const Traces& traces) {
    answered([&] {
        const inspect::RecordedRun run(traces);
        answered([&] { inspect::answer_of(inspect::table_of(run)); });
        answered([&] { inspect::recorded_work(run, {}); });
        inspect::ReplayOptions options;
        options.executors = {inspect::ExecutorKind::fast};
        answered([&] { inspect::replay(run, options, {}); });
        for (const std::uint32_t number : run.frames()) {
            answered([&] { inspect::map_values(run.frame(number), inspect::MapKind::gp); });
        }
        answered([&] {
            inspect::FrameInquiry frame(run, std::nullopt);
            answered([&] { inspect::answer_of(inspect::why(frame, center_px, center_px)); });
            answered(
                [&] { inspect::answer_of(inspect::why_not(frame, center_px, center_px, {})); });
            const inspect::Expectation cell{std::array{30, 30, 20}, {}, {}};
            answered(
                [&] { inspect::answer_of(inspect::why_not(frame, center_px, center_px, cell)); });
        });
    });
}

}  // namespace

TEST_SUITE("crafted runs") {
    TEST_CASE("slices smaller than the header's shape are not read") {
        Traces traces = sphere_traces();
        CHECK(unknown_at_center(traces).empty());
        change<schema::VolumeHeader>(traces, [](schema::VolumeHeaderT& header) {
            header.nx = header.ny = max_volume_voxels;
        });
        CHECK(unknown_at_center(traces).find("has another size") != std::string::npos);
    }
    TEST_CASE("a phantom that is not of the header's shape does not stand in for its voxels") {
        Traces traces = sphere_traces();
        change<schema::VolumeHeader>(traces, [](schema::VolumeHeaderT& header) { header.nz *= 8; });
        change<schema::Slices>(traces, [](schema::SlicesT& slices) { slices.volume += 1; });
        CHECK(unknown_at_center(traces).find("has another size") != std::string::npos);
        change<schema::VolumeHeader>(
            traces, [](schema::VolumeHeaderT& header) { header.source = "phantom:none"; });
        CHECK(unknown_at_center(traces).find("no phantom") != std::string::npos);
    }
    TEST_CASE("a cell outside of the volume has no voxels") {
        Traces traces = sphere_traces();
        change<schema::RegionPrograms>(traces, [](schema::RegionProgramsT& programs) {
            for (const auto& region : programs.regions) {
                for (schema::Origin& origin : region->origins) {
                    origin = schema::Origin(65535, 65535, origin.inside(), 0, 0, 0);
                }
            }
        });
        CHECK(unknown_at_center(traces).starts_with("cell (65535, 65535, "));
    }
    TEST_CASE("a slab outside of the volume has no voxels") {
        for (const std::uint32_t slab : {0x4000'0000U, 0x7FFF'FFFFU, 0xFFFF'FFFFU}) {
            CAPTURE(slab);
            Traces traces = sphere_traces();
            change<schema::RegionPrograms>(traces, [&](schema::RegionProgramsT& programs) {
                for (const auto& region : programs.regions) {
                    for (schema::Segment& s : region->segments) {
                        s = schema::Segment(s.surface(), slab - s.slab(), s.first_word(),
                                            s.word_count());
                    }
                }
            });
            CHECK(unknown_at_center(traces).find("is outside of the volume") != std::string::npos);
        }
    }
    TEST_CASE("100,000 frames that each claim to be a later sample are opened one by one") {
        Traces traces = sphere_traces();
        for (inspect::NodeTrace& node : traces) {
            if (node.info.role != schema::Role::renderer || node.info.index != 0) {
                continue;
            }
            const auto entries = node.entries;
            auto added = std::make_shared<std::vector<bus::Message>>();
            for (const bus::trace::Entry& entry : entries) {
                const bus::Message message = node.load(entry);
                const auto* begin = message.as<schema::BeginFrame>();
                for (std::uint32_t n = 0; begin != nullptr && n < 100'000; ++n) {
                    schema::BeginFrameT object;
                    begin->UnPackTo(&object);
                    object.draw->frame = 1000 + n;
                    object.draw->samples = 4;
                    object.draw->sample = 1;
                    object.draw->read_back = object.draw->read_depths = false;
                    added->push_back(with_body(message, bus::pack(object)));
                    node.entries.push_back(entry);
                    node.entries.back().offset = entries.size() + added->size() - 1;
                }
            }
            node.load = [first = node.load, count = entries.size(),
                         added](const bus::trace::Entry& entry) {
                return entry.offset < count ? first(entry) : added->at(entry.offset - count);
            };
        }
        const inspect::RecordedRun run(traces);
        CHECK(run.frame(100'500).earlier == nullptr);
    }
    TEST_CASE("a Renderer that was sent another frame than the others is left out") {
        Traces traces = sphere_traces();
        for (std::size_t n = 0; n < traces.size(); ++n) {
            if (traces[n].info.role != schema::Role::renderer || traces[n].info.index != 0) {
                continue;
            }
            Traces one = {traces[n]};
            change<schema::BeginFrame>(one, [](schema::BeginFrameT& begin) {
                begin.draw->width = begin.draw->height = 1024;
                begin.assignment.assign(64, 0);
            });
            traces[n] = one.front();
        }
        const inspect::RecordedRun run(traces);
        const inspect::RecordedFrame frame = run.frame(run.frames().back());
        REQUIRE(frame.missing.size() == 1);
        CHECK(frame.missing.front().find("differs from that of another node") != std::string::npos);
        ask_all(traces);
    }
    TEST_CASE("a Renderer has sums for no more regions than its backing store holds") {
        Traces traces = sphere_traces(4);
        change<schema::BeginFrame>(traces, [](schema::BeginFrameT& begin) {
            begin.draw->width = begin.draw->height = 4096;
            begin.assignment.assign(1024, 0);
        });
        const inspect::RecordedRun run(traces);
        const inspect::RecordedFrame frame = run.frame(run.frames().back());
        REQUIRE(!frame.missing.empty());
        CHECK(frame.missing.front().find("sums fit for") != std::string::npos);
    }
    TEST_CASE("a primitive that ends before its edges is not measured") {
        Traces traces = sphere_traces();
        const inspect::WhyFinding whole = why_center(inspect::RecordedRun(traces));
        REQUIRE(whole.shown() != nullptr);
        const inspect::TriangleName name = whole.shown()->cell.value().name;
        change<schema::RegionPrograms>(traces, [&](schema::RegionProgramsT& programs) {
            for (const auto& region : programs.regions) {
                for (schema::Segment& s :
                     region->segments) {  // The SETENABS of its first triangle.
                    s = schema::Segment(s.surface(), s.slab(), s.first_word(), 1);
                }
                // Each slab's program has one primitive left: of the triangle at the center.
                for (schema::Origin& o : region->origins) {
                    o = schema::Origin(static_cast<std::uint16_t>(name.i),
                                       static_cast<std::uint16_t>(name.j), o.inside(), 0,
                                       static_cast<std::uint8_t>(name.triangle), 0);
                }
            }
        });
        const inspect::RecordedRun run(traces);
        inspect::FrameInquiry frame(run, std::nullopt);
        const inspect::Expectation cell{std::array{name.i, name.j, name.k}, {}, name.triangle};
        const std::string text =
            inspect::answer_of(inspect::why_not(frame, center_px, center_px, cell)).text();
        CAPTURE(text);
        CHECK(text.find("does not cover the pixel") != std::string::npos);
    }
    TEST_CASE("a map of a sample that is not the last has no colors") {
        const Traces traces = sphere_traces(4);
        const inspect::RecordedRun run(traces);
        const inspect::RecordedFrame first = run.frame(run.frames().front());
        REQUIRE(!first.has_pixels());
        const inspect::MapValues map = inspect::map_values(first, inspect::MapKind::busy);
        CHECK(std::ranges::all_of(map.picture, [](std::uint32_t pixel) { return pixel == 0; }));
    }
    TEST_CASE("the parts of a region together repeat no more instructions than one program may") {
        // 3.3 million instructions each, which one program may execute.
        const isa::Program loops =
            isa::assemble("LOOP #200\nLOOP #200\nLOOP #40\nNOP\nENDLOOP\nENDLOOP\nENDLOOP\n");
        renderer::RegionPlan plan;
        plan.parts.push_back({PartKind::segment, {7, 0, 1, loops.words, 0}});
        const auto run = [&] {
            isa::reference::Reference pixel(isa::reference::Window{0, 0, 1, 1});
            return inspect::run_region(plan, pixel).counts.instructions;
        };
        const std::uint64_t one = run();
        CHECK(one > isa::max_repeated_instructions / 2);
        plan.parts.push_back({PartKind::segment, {8, 0, 2, loops.words, 0}});
        const std::uint64_t limit = isa::max_repeated_instructions + 14;
        REQUIRE(2 * one > limit);
        const std::string error = error_of(run);
        CHECK_MESSAGE(error.find("gp-2 surface 8 slab 0+0: the region's programs executed " +
                                 std::to_string(limit + 1) + " instructions; the limit is " +
                                 std::to_string(limit) + ": 14 words") == 0,
                      error);
    }
    TEST_CASE("mutated runs are answered or refused") {
        const auto seed = seed_or<std::uint64_t>(1);
        MESSAGE("seed " << seed);
        std::mt19937_64 random(seed);
        const Traces whole = sphere_traces(1), samples = sphere_traces(4);
        for (int n = 0; n < 40; ++n) {
            CAPTURE(n);
            ask_all(mutated(n % 4 == 3 ? samples : whole, n % 2 == 0 ? 40 : 5, random));
        }
    }
}
