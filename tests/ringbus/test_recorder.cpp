#include "ringbus/trace/recorder.hpp"

#include <doctest/doctest.h>
#include <fmt/core.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdlib>
#include <deque>
#include <map>
#include <random>
#include <set>

#include "tests/ringbus/scratch_folder.hpp"
#include "tests/ringbus/wire_bytes.hpp"

using namespace pxpl5;
using namespace pxpl5::bus;
using test::WireBytes;
using trace::Recorder;
using trace::TraceFile;

namespace {

trace::Info info_for(schema::Recording mode) {
    trace::Info info;
    info.build = "pxpl5 test";
    info.schema_hash = schema_hash();
    info.recording = mode;
    return info;
}

Message from(NodeId source, const Payload& payload) {
    WireBytes wire(payload);
    wire.header.mutate_source(source);
    return wire.read();
}

Payload surface(std::uint16_t number, std::uint32_t revision) {
    schema::SetSurfaceT body;
    body.surface = number;
    body.revision = revision;
    return pack(body);
}

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

Payload end_of(std::uint32_t volume) {
    schema::VolumeEndT body;
    body.volume = volume;
    return pack(body);
}

Payload topology_with(std::uint16_t nodes) {
    schema::TopologyT body;
    for (std::uint16_t id = 0; id < nodes; ++id) {
        body.nodes.push_back(std::make_unique<schema::NodeInfoT>());
        body.nodes.back()->id = id;
        body.nodes.back()->role = id == 0 ? schema::Role::host : schema::Role::gp;
        body.nodes.back()->endpoint = "ipc:///somewhere";
    }
    return pack(body);
}

Payload frame_done(std::uint32_t frame) {
    schema::FrameDoneT body;
    body.frame = frame;
    body.width = body.height = 128;
    body.views = 1;
    body.region_cycles = {1};
    return pack(body);
}

/// What a node would know after these messages.
struct Knowledge {
    std::size_t nodes = 0;
    std::uint32_t volume = 0;
    bool complete = false;
    std::set<std::uint32_t> slices;
    std::map<std::uint16_t, std::uint32_t> surfaces;
    bool operator==(const Knowledge&) const = default;

    void learn(const Message& message) {
        if (const auto* topology = message.as<schema::Topology>()) {
            nodes = topology->nodes()->size();
        } else if (const auto* header = message.as<schema::VolumeHeader>()) {
            *this = Knowledge{nodes, header->volume(), false, {}, {}};
        } else if (const auto* some = message.as<schema::Slices>()) {
            slices.insert(some->first_slice());
        } else if (message.kind() == Body::VolumeEnd) {
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

/// "Topology SetSurface"
std::string kinds_in(const std::filesystem::path& path) {
    std::string kinds;
    const TraceFile file(path);
    for (const trace::Entry& entry : file.entries()) {
        kinds += (kinds.empty() ? "" : " ") + kind_name(entry.kind());
    }
    return kinds;
}

std::uint64_t seed() {
    const char* given = std::getenv("PXPL5_SEED");
    const std::uint64_t value = given != nullptr ? std::strtoull(given, nullptr, 0) : 1;
    MESSAGE("PXPL5_SEED=" << value);
    return value;
}

/// Gives the messages it was filled with; an empty place is a quiet moment. Keeps what is sent.
class QueueLink final : public Link {
  public:
    NodeId id() const override { return 5; }
    const std::string& endpoint() const override { return endpoint_; }
    void add_peer(NodeId, const std::string&) override {}
    void remove_peer(NodeId) override {}
    void send(NodeId to, Payload payload) override {
        receivers.push_back(to);
        sent.push_back(WireBytes(payload).read());
    }
    std::optional<Message> receive() override {
        if (input.empty() || !input.front()) {
            return std::nullopt;
        }
        const Message message = *input.front();
        input.pop_front();
        return message;
    }
    bool wait(int timeout_ms) override {
        waits_ms.push_back(timeout_ms);
        if (!input.empty() && !input.front()) {
            input.pop_front();
        }
        return !input.empty();
    }

    std::deque<std::optional<Message>> input;
    std::vector<Message> sent;
    std::vector<NodeId> receivers;
    std::vector<int> waits_ms;

  private:
    std::string endpoint_ = "queue";
};

/// The next file operations of this process fail at `bytes`.
class FileSizeLimit {
  public:
    explicit FileSizeLimit(std::uint64_t bytes) {
        std::signal(SIGXFSZ, SIG_IGN);
        getrlimit(RLIMIT_FSIZE, &before_);
        rlimit tight = before_;
        tight.rlim_cur = bytes;
        setrlimit(RLIMIT_FSIZE, &tight);
    }
    ~FileSizeLimit() { setrlimit(RLIMIT_FSIZE, &before_); }
    FileSizeLimit(const FileSizeLimit&) = delete;
    FileSizeLimit& operator=(const FileSizeLimit&) = delete;

  private:
    rlimit before_{};
};

}  // namespace

TEST_SUITE("ringbus/recorder") {
    TEST_CASE("a flight holds what it was handed, without a copy") {
        const test::ScratchFolder folder;
        Recorder recorder(folder / "a.mcap", info_for(schema::Recording::flight));
        WireBytes wire(frame_done(1));
        const Message message = wire.read();
        const long owners = wire.body.use_count();
        recorder.note(message);
        CHECK(wire.body.use_count() == owners + 1);
        CHECK(!std::filesystem::exists(folder / "a.mcap"));
    }

    TEST_CASE("a flight holds the newest messages: so many bytes, and so long") {
        const test::ScratchFolder folder;
        const std::size_t size = frame_done(1).bytes().size();
        for (const bool by_bytes : {true, false}) {
            trace::FlightLimits limits;
            limits.window_bytes = by_bytes ? 10 * size : 1000 * size;
            limits.span = std::chrono::seconds(by_bytes ? 1000 : 9);
            Recorder recorder(folder / "a.mcap", info_for(schema::Recording::flight), limits);
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

    TEST_CASE("whatever a flight has forgotten, its node would know the same again") {
        const test::ScratchFolder folder;
        std::mt19937_64 random(seed());
        for (int round = 0; round < 40; ++round) {
            CAPTURE(round);
            trace::FlightLimits limits;
            limits.window_bytes = random() % 3000;
            Recorder recorder(folder / "a.mcap", info_for(schema::Recording::flight), limits);
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

    TEST_CASE("slices beyond the limit are given up, all of them, and their header stays") {
        const test::ScratchFolder folder;
        trace::FlightLimits limits;
        limits.window_bytes = 1;  // The newest message alone.
        limits.setup_bytes = 3000;
        Recorder recorder(folder / "a.mcap", info_for(schema::Recording::flight), limits);
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

    TEST_CASE("saving disturbs nothing: again it gives the same, and later more") {
        const test::ScratchFolder folder;
        Recorder recorder(folder / "a.mcap", info_for(schema::Recording::flight));
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

    TEST_CASE("a save that fails leaves the former file, and may be tried again") {
        const test::ScratchFolder folder;
        Recorder recorder(folder / "a.mcap", info_for(schema::Recording::flight));
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

    TEST_CASE("a full recording is in its file once the node has been idle, or for its patience") {
        const test::ScratchFolder folder;
        Recorder recorder(folder / "a.mcap", info_for(schema::Recording::full));
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

    TEST_CASE("a recording that takes no more fails once by name, and again when it is saved") {
        const test::ScratchFolder folder;
        Recorder recorder(folder / "a.mcap", info_for(schema::Recording::full));
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

TEST_SUITE("ringbus/recording_link") {
    TEST_CASE("what a link hands on is recorded; SaveTrace is answered and not handed on") {
        const test::ScratchFolder folder;
        Recorder recorder(folder / "a.mcap", info_for(schema::Recording::flight));
        QueueLink queue;
        queue.input = {from(0, topology_with(2)), from(0, pack(schema::SaveTraceT{})),
                       from(1, surface(7, 1))};
        trace::RecordingLink link(queue, recorder);
        CHECK(link.id() == 5);
        CHECK(link.receive()->kind() == Body::Topology);
        const std::optional<Message> next = link.receive();
        REQUIRE(next);
        CHECK(next->as<schema::SetSurface>()->surface() == 7);
        CHECK(!link.receive());
        REQUIRE(queue.sent.size() == 1);
        CHECK(queue.receivers[0] == host_id);
        const auto* saved = queue.sent[0].as<schema::TraceSaved>();
        REQUIRE(saved != nullptr);
        CHECK(saved->messages() == 2);
        CHECK(saved->bytes() == std::filesystem::file_size(folder / "a.mcap"));
        CHECK(saved->error() == nullptr);
        CHECK(kinds_in(folder / "a.mcap") == "Topology SaveTrace");
    }

    TEST_CASE("a link that waits in vain writes what waits for the file") {
        const test::ScratchFolder folder;
        Recorder recorder(folder / "a.mcap", info_for(schema::Recording::full));
        QueueLink queue;
        queue.input = {from(0, surface(1, 1))};
        trace::RecordingLink link(queue, recorder);
        CHECK(link.receive());
        CHECK(!link.wait(1000));
        CHECK(TraceFile(folder / "a.mcap").entries().size() == 1);
        CHECK(queue.waits_ms.size() == 2);
        CHECK(queue.waits_ms[0] + queue.waits_ms[1] == 1000);
        CHECK(!link.wait(1000));
        CHECK(queue.waits_ms.back() == 1000);  // Nothing waits any more.
    }

    TEST_CASE("the host is told when recording fails, once, and the node's messages still come") {
        const test::ScratchFolder folder;
        Recorder recorder(folder / "a.mcap", info_for(schema::Recording::full));
        QueueLink queue;
        queue.input = {from(0, surface(1, 1)), std::nullopt};
        trace::RecordingLink link(queue, recorder);
        const FileSizeLimit limit(10);
        CHECK(link.receive());
        CHECK(!link.receive());
        CHECK(!link.wait(1000));
        REQUIRE(queue.sent.size() == 1);
        const auto* fault = queue.sent[0].as<schema::Fault>();
        REQUIRE(fault != nullptr);
        CHECK(fault->node() == 5);
        CHECK(fault->reason()->str().starts_with("recording stops: cannot write trace "));
        queue.input = {from(0, surface(2, 1)), from(0, pack(schema::SaveTraceT{}))};
        CHECK(link.receive()->as<schema::SetSurface>()->surface() == 2);
        CHECK(!link.receive());
        REQUIRE(queue.sent.size() == 2);
        CHECK(queue.sent[1].as<schema::TraceSaved>()->error()->str().find("File too large") !=
              std::string::npos);
    }
}
