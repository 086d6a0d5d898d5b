#include "ringbus/trace/recorder.hpp"

#include <doctest/doctest.h>
#include <fmt/core.h>

#include <cstdlib>
#include <map>
#include <random>
#include <set>

#include "tests/random_seed.hpp"
#include "tests/ringbus/scratch_folder.hpp"
#include "tests/ringbus/trace/recorder_support.hpp"

using namespace pxpl5;
using namespace pxpl5::bus;
using namespace pxpl5::test;
using trace::Recorder;
using trace::TraceFile;

namespace {

Payload no_surface(std::uint16_t number) {
    schema::RemoveSurfaceT body;
    body.surface = number;
    return pack(body);
}

Payload header_of(std::uint32_t volume) {
    schema::VolumeHeaderT body;
    body.volume = volume;
    body.name = "a volume";
    body.nx = body.ny = body.nz = 2;
    body.voxel_to_patient = std::make_unique<schema::Matrix>();
    return pack(body);
}

Payload slices_of(std::uint32_t volume, std::uint32_t first, std::size_t bytes = 8) {
    schema::SlicesT body;
    body.volume = volume;
    body.first_slice = first;
    body.slice_count = 1;
    body.values.resize(bytes);
    return pack(body);
}

Payload scene_of(std::uint32_t scene) {
    schema::SceneBeginT body;
    body.scene = scene;
    return pack(body);
}

Payload part_of(std::uint32_t scene, std::uint32_t slab) {
    schema::ScenePartT body;
    body.scene = scene;
    body.slab = slab;
    return pack(body);
}

Payload end_of(std::uint32_t volume) {
    schema::VolumeEndT body;
    body.volume = volume;
    return pack(body);
}

Payload frame_done(std::uint32_t frame) {
    schema::FrameDoneT body;
    body.frame = frame;
    body.width = body.height = 128;
    body.views = 1;
    body.region_renderers.assign(1, 0);
    body.region_cycles = {1};
    return pack(body);
}

/// The set-up of a node after these messages.
struct Knowledge {
    std::size_t nodes = 0;
    std::uint32_t volume = 0;  ///< Or scene.
    bool complete = false;
    std::set<std::uint32_t> slices;  ///< Or slabs of a scene.
    std::map<std::uint16_t, std::uint32_t> surfaces;
    bool operator==(const Knowledge&) const = default;

    void learn(const Message& message) {
        if (const auto* topology = message.as<schema::Topology>()) {
            nodes = topology->nodes()->size();
        } else if (const auto* header = message.as<schema::VolumeHeader>()) {
            *this = Knowledge{nodes, header->volume(), false, {}, {}};
        } else if (const auto* scene = message.as<schema::SceneBegin>()) {
            *this = Knowledge{nodes, scene->scene(), false, {}, {}};
        } else if (const auto* some = message.as<schema::Slices>()) {
            slices.insert(some->first_slice());
        } else if (const auto* part = message.as<schema::ScenePart>()) {
            slices.insert(part->slab());
        } else if (message.kind() == Body::VolumeEnd || message.kind() == Body::SceneEnd) {
            complete = true;
        } else if (const auto* set = message.as<schema::SetSurface>()) {
            surfaces[set->surface()] = set->revision();
        } else if (const auto* removed = message.as<schema::RemoveSurface>()) {
            surfaces.erase(removed->surface());
        }
    }
};

Knowledge knowledge_in(const TraceFile& file) {
    Knowledge knowledge;
    for (const trace::Entry& entry : file.entries()) {
        knowledge.learn(file.load(entry));
    }
    return knowledge;
}

}  // namespace

TEST_SUITE("ringbus/recorder") {
    TEST_CASE("a flight keeps received messages without a copy") {
        const test::ScratchFolder folder;
        Recorder recorder(folder / "a.mcap", info_for(Recording::flight));
        WireBytes wire(frame_done(1));
        const Message message = wire.read();
        const long owners = wire.body.use_count();
        recorder.note(message);
        CHECK(wire.body.use_count() == owners + 1);
        CHECK(!std::filesystem::exists(folder / "a.mcap"));
    }

    TEST_CASE("a flight keeps the newest messages, limited in bytes and in time") {
        const test::ScratchFolder folder;
        const std::size_t size = frame_done(1).bytes().size();
        for (const bool by_bytes : {true, false}) {
            trace::Limits limits;
            limits.share_bytes = by_bytes ? 10 * size : 1000 * size;
            limits.span = std::chrono::seconds(by_bytes ? 1000 : 9);
            Recorder recorder(folder / "a.mcap", info_for(Recording::flight), limits);
            trace::Instant when = trace::Instant::now();
            for (std::uint32_t frame = 1; frame <= 30; ++frame) {
                recorder.note(from(2, frame_done(frame)), when);
                when.steady += std::chrono::seconds(1);
                when.wall_ns += 1'000'000'000;
            }
            CHECK(recorder.save().messages == 10);
            const TraceFile file(folder / "a.mcap");
            REQUIRE(file.entries().size() == 10);
            CHECK(file.info().dropped == 20);
            CHECK(file.load(file.entries()[0]).as<schema::FrameDone>()->frame() == 21);
            CHECK(file.load(file.entries()[9]).as<schema::FrameDone>()->frame() == 30);
            CHECK(file.entries()[9].wall_ns - file.entries()[0].wall_ns == 9'000'000'000);
        }
    }

    TEST_CASE("a flight keeps the displayed frame, however old it is") {
        const test::ScratchFolder folder;
        trace::Limits limits;
        limits.span = std::chrono::seconds(9);
        Recorder recorder(folder / "a.mcap", info_for(Recording::flight), limits);
        trace::Instant when = trace::Instant::now();
        const auto note_after = [&](int seconds, const Payload& payload) {
            when.steady += std::chrono::seconds(seconds);
            recorder.note(from(2, payload), when);
        };
        note_after(0, no_surface(1));
        note_after(1, frame_done(1));
        note_after(1, frame_done(2));
        note_after(60, no_surface(2));
        recorder.save();
        const TraceFile file(folder / "a.mcap");
        REQUIRE(file.entries().size() == 3);
        CHECK(file.load(file.entries()[1]).as<schema::FrameDone>()->frame() == 2);
        note_after(60, frame_done(3));
        note_after(1, frame_done(4));
        CHECK(recorder.save().messages == 2);
    }

    TEST_CASE("a flight keeps the last two frames beyond its share, and all else within it") {
        const test::ScratchFolder folder;
        const std::size_t size = frame_done(1).bytes().size();
        trace::Limits limits;
        limits.share_bytes = 6 * size;
        limits.window_bytes = 11 * size;
        Recorder recorder(folder / "a.mcap", info_for(Recording::flight), limits);
        for (std::uint32_t frame = 1; frame <= 30; ++frame) {
            recorder.note(from(2, frame_done(frame)));
        }
        CHECK(recorder.save().messages == 6);
        const auto note_others = [&](int count) {
            for (int i = 0; i < count; ++i) {
                recorder.note(from(2, pack(schema::TraceSavedT{})));
            }
            return recorder.save().messages;
        };
        const std::size_t other = pack(schema::TraceSavedT{}).bytes().size();
        const auto beyond_share = static_cast<int>(5 * size / other);
        CHECK(note_others(beyond_share) == 2U + static_cast<unsigned>(beyond_share));
        CHECK(note_others(20 * beyond_share) <= 11 * size / other);
    }

    TEST_CASE("replaying a flight restores the node's set-up, whatever was dropped") {
        const test::ScratchFolder folder;
        const std::uint64_t seed = pxpl5::test::seed_or<std::uint64_t>(1);
        CAPTURE(seed);
        std::mt19937_64 random(seed);
        for (int round = 0; round < 40; ++round) {
            CAPTURE(round);
            trace::Limits limits;
            limits.window_bytes = random() % 3000;
            Recorder recorder(folder / "a.mcap", info_for(Recording::flight), limits);
            Knowledge all;
            std::uint32_t volume = 0, revision = 0;
            const auto say = [&](const Payload& payload) {
                const Message message = from(0, payload);
                recorder.note(message);
                all.learn(message);
            };
            say(topology_with(5));
            for (int i = 0; i < 200; ++i) {
                const auto number = static_cast<std::uint16_t>(random() % 4);
                switch (random() % 40) {
                    case 0:
                        say(header_of(++volume));
                        for (std::uint32_t z = 0; z < 6; ++z) {
                            say(slices_of(volume, z));
                        }
                        say(end_of(volume));
                        break;
                    case 6:
                        say(scene_of(++volume));
                        say(part_of(volume, 3));
                        say(part_of(volume, 5));
                        say(pack(schema::SceneEndT{}));
                        break;
                    case 1:
                    case 2:
                        say(no_surface(number));
                        break;
                    case 3:
                    case 4:
                    case 5:
                        say(surface(number, ++revision));
                        break;
                    default:
                        say(frame_done(1));
                }
            }
            recorder.save();
            const TraceFile file(folder / "a.mcap");
            CHECK(knowledge_in(file) == all);
            CHECK(file.entries().size() < 60);
        }
    }

    TEST_CASE("slices beyond the limit are all dropped, and their header stays") {
        const test::ScratchFolder folder;
        trace::Limits limits;
        limits.window_bytes = 1;  // The newest message alone.
        limits.setup_bytes = 3000;
        Recorder recorder(folder / "a.mcap", info_for(Recording::flight), limits);
        const auto note = [&](const Payload& payload) { recorder.note(from(0, payload)); };
        note(header_of(1));
        for (std::uint32_t z = 0; z < 5; ++z) {
            note(slices_of(1, z, 1000));
        }
        note(end_of(1));
        note(surface(1, 1));
        note(frame_done(1));
        recorder.save();
        CHECK(kinds_in(folder / "a.mcap") == "VolumeHeader VolumeEnd SetSurface FrameDone");
        CHECK(TraceFile(folder / "a.mcap").info().dropped == 5);
        note(header_of(2));  // A small one is held again.
        note(slices_of(2, 0, 1000));
        note(end_of(2));
        note(frame_done(2));
        recorder.save();
        CHECK(kinds_in(folder / "a.mcap") == "VolumeHeader Slices VolumeEnd FrameDone");
    }

    TEST_CASE("saving changes nothing: a second save is equal, a later one has more") {
        const test::ScratchFolder folder;
        Recorder recorder(folder / "a.mcap", info_for(Recording::flight));
        recorder.note(from(0, topology_with(3)));
        recorder.note(from(0, surface(1, 1)));
        const Recorder::Saved first = recorder.save(), again = recorder.save();
        CHECK(first.messages == 2);
        CHECK(first.bytes == again.bytes);
        CHECK(first.bytes == std::filesystem::file_size(folder / "a.mcap"));
        recorder.note(from(0, surface(2, 1)));
        CHECK(recorder.save().messages == 3);
        CHECK(TraceFile(folder / "a.mcap").cut() == "");
        CHECK(!std::filesystem::exists(folder / "a.mcap.part"));
    }

    TEST_CASE("a failed save leaves the former file, and can be repeated") {
        const test::ScratchFolder folder;
        Recorder recorder(folder / "a.mcap", info_for(Recording::flight));
        recorder.note(from(0, surface(1, 1)));
        recorder.save();
        recorder.note(from(0, surface(2, 1)));
        {
            const FileSizeLimit limit(100);
            CHECK_THROWS_AS(recorder.save(), trace::TraceError);
        }
        CHECK(TraceFile(folder / "a.mcap").entries().size() == 1);
        CHECK(!std::filesystem::exists(folder / "a.mcap.part"));
        CHECK(recorder.save().messages == 2);
    }

    TEST_CASE("a full recording is in its file after idle time, or after a delay at most") {
        const test::ScratchFolder folder;
        Recorder recorder(folder / "a.mcap", info_for(Recording::full));
        const auto count = [&] { return TraceFile(folder / "a.mcap").entries().size(); };
        trace::Instant when = trace::Instant::now();
        CHECK(!recorder.has_unwritten());
        recorder.note(from(0, surface(1, 1)), when);
        CHECK(recorder.has_unwritten());
        CHECK(count() == 0);
        recorder.idle();
        CHECK(count() == 1);
        recorder.note(from(0, surface(2, 1)), when);
        when.steady += Recorder::patience / 2;
        recorder.note(from(0, surface(3, 1)), when);
        CHECK(count() == 1);
        when.steady += Recorder::patience / 2;
        recorder.note(from(0, surface(4, 1)), when);
        CHECK(count() == 4);
        CHECK(!recorder.has_unwritten());
        recorder.note(from(0, surface(5, 1)), when);
        CHECK(recorder.save().messages == 5);
        CHECK(count() == 5);
        recorder.close();
        CHECK(TraceFile(folder / "a.mcap").cut() == "");
    }

    TEST_CASE("a full recording closes at its limit, and reports it once") {
        const test::ScratchFolder folder;
        trace::Limits limits;
        limits.file_bytes = 20'000;
        Recorder recorder(folder / "a.mcap", info_for(Recording::full), limits);
        std::size_t noted = 0;
        std::string error;
        while (error.empty()) {
            try {
                recorder.note(from(0, slices_of(1, static_cast<std::uint32_t>(noted), 100)));
                recorder.idle();
                ++noted;
                REQUIRE(noted < 1000);
            } catch (const trace::TraceError& failure) {
                error = failure.what();
            }
        }
        CHECK_MESSAGE(error.ends_with(" bytes, the limit is 20000"), error);
        CHECK_NOTHROW(recorder.note(from(0, surface(1, 1))));
        CHECK_NOTHROW(recorder.close());
        const TraceFile file(folder / "a.mcap");
        CHECK(file.cut() == "");
        CHECK(file.entries().size() == noted);
    }

    TEST_CASE("a recording that cannot grow fails once with the reason, and again when saved") {
        const test::ScratchFolder folder;
        Recorder recorder(folder / "a.mcap", info_for(Recording::full));
        recorder.note(from(0, surface(1, 1)));
        const std::uint64_t bytes = recorder.save().bytes;
        recorder.note(from(0, surface(2, 1)));
        const std::string text = fmt::format("cannot write trace {} at byte {}: File too large",
                                             (folder / "a.mcap").string(), bytes);
        {
            const FileSizeLimit limit(bytes + 10);
            CHECK_THROWS_WITH_AS(recorder.idle(), text.c_str(), trace::TraceError);
        }
        CHECK_NOTHROW(recorder.note(from(0, surface(3, 1))));
        CHECK_NOTHROW(recorder.idle());
        CHECK_THROWS_WITH_AS(recorder.save(), text.c_str(), trace::TraceError);
        CHECK_NOTHROW(recorder.close());
        CHECK(TraceFile(folder / "a.mcap").entries().size() == 1);
    }
}
