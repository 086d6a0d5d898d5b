// The Renderer's node, driven by hand-made messages.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <string>

#include "renderer_firmware/node.hpp"
#include "ringbus/ranges.hpp"
#include "tests/renderer_firmware/triangles.hpp"

using namespace pxpl5;
namespace schema = bus::schema;
using schema::Body;

namespace {

using WordList = std::vector<std::uint32_t>;
constexpr bus::NodeId first_gp = 1, first_renderer = 10, frame_buffer = 20;
constexpr std::size_t tile = 128 * 128;

struct Outbox final : bus::Outbox {
    using bus::Outbox::send;
    struct Sent {
        bus::NodeId to;
        bus::Payload payload;
    };
    void send(bus::NodeId to, bus::Payload payload) override {
        sent.push_back({to, std::move(payload)});
    }
    std::vector<Sent> sent;
};

struct SegmentWords {
    std::uint16_t surface;
    std::uint32_t slab;
    WordList words;
};
struct RegionWords {
    std::uint16_t region;
    std::vector<SegmentWords> segments;
};

bus::Payload programs(std::uint32_t frame, int gp, const std::vector<RegionWords>& regions) {
    schema::RegionProgramsT body;
    body.frame = frame;
    body.gp = static_cast<std::uint16_t>(gp);
    for (const RegionWords& region : regions) {
        auto program = std::make_unique<schema::RegionProgramT>();
        program->region = region.region;
        for (const SegmentWords& s : region.segments) {
            program->segments.emplace_back(s.surface, s.slab,
                                           static_cast<std::uint32_t>(program->words.size()),
                                           static_cast<std::uint32_t>(s.words.size()));
            program->words.insert(program->words.end(), s.words.begin(), s.words.end());
        }
        body.regions.push_back(std::move(program));
    }
    return bus::pack(body);
}

bus::Payload begin(std::uint32_t frame, const std::vector<std::uint16_t>& assignment) {
    schema::BeginFrameT body;
    body.draw = std::make_unique<schema::DrawFrameT>();
    body.draw->frame = frame;
    body.draw->width = static_cast<std::uint32_t>(128 * assignment.size());
    body.draw->height = 128;
    auto view = std::make_unique<schema::ViewT>();
    view->voxel_to_eye = std::make_unique<schema::Matrix>();
    view->projection = std::make_unique<schema::Matrix>();
    body.draw->views.push_back(std::move(view));
    body.draw->ambient = 1;
    body.draw->specular_power = 1;
    body.draw->background = std::make_unique<schema::Rgb>(10, 20, 30);
    // No lights and full ambient light: a pixel shows its surface's colour.
    body.draw->surfaces = {
        {0, 1, schema::Rgb(200, 100, 50), false, schema::SlabChoice::all, bus::max_opacity},
        {1, 1, schema::Rgb(1, 2, 3), false, schema::SlabChoice::all, bus::max_opacity}};
    body.assignment = assignment;
    return bus::pack(body);
}

constexpr std::uint32_t background = 10 | 20 << 8 | 30 << 16;
constexpr std::uint32_t colours[] = {200 | 100 << 8 | 50 << 16, 1 | 2 << 8 | 3 << 16};

/// A sheet over the whole region, of surface `surface`.
WordList sheet(std::uint32_t surface, std::uint32_t depth) {
    test::TrianglePlanes t;
    put_edges({-3000, -3000}, {9000, -3000}, {-3000, 9000}, t);
    t.z[2] = static_cast<std::int32_t>(depth << 8);
    t.normals[2][2] = 500 << 16;
    t.surface = surface + 1;
    WordList words;
    append(t, words);
    return words;
}

/// One Renderer among `renderers`, with `gps` GPs.
struct Bench {
    Bench(int gps, int renderers, int index)
        : id(static_cast<bus::NodeId>(first_renderer + index)) {
        schema::TopologyT topology;
        const auto add = [&](int node_id, schema::Role role, int i) {
            auto info = std::make_unique<schema::NodeInfoT>();
            info->id = static_cast<bus::NodeId>(node_id);
            info->role = role;
            info->index = static_cast<std::uint16_t>(i);
            topology.nodes.push_back(std::move(info));
        };
        add(bus::host_id, schema::Role::host, 0);
        for (int i = 0; i < gps; ++i) {
            add(first_gp + i, schema::Role::gp, i);
        }
        for (int i = 0; i < renderers; ++i) {
            add(first_renderer + i, schema::Role::renderer, i);
        }
        add(frame_buffer, schema::Role::frame_buffer, 0);
        take(bus::host_id, bus::pack(topology));
    }

    void take(int source, const bus::Payload& payload) {
        schema::Header header;
        header.mutate_magic(bus::header_magic);
        header.mutate_version(bus::protocol_version);
        header.mutate_kind(static_cast<std::uint16_t>(payload.kind()));
        header.mutate_source(static_cast<bus::NodeId>(source));
        header.mutate_destination(id);
        header.mutate_sequence(sequence++);
        header.mutate_body_bytes(payload.bytes().size());
        // A message body starts at a multiple of 8 bytes, a payload need not.
        const std::size_t size = payload.bytes().size();
        const auto copy = std::make_shared<std::vector<std::uint64_t>>(size / 8 + 1);
        std::memcpy(copy->data(), payload.bytes().data(), size);
        const auto* bytes = reinterpret_cast<const std::uint8_t*>(copy->data());
        node.receive({header, {bytes, size}, copy}, out);
    }
    void from_gp(int gp, const bus::Payload& payload) { take(first_gp + gp, payload); }

    /// The text of the NodeFault that a message causes.
    std::string refused(int source, const bus::Payload& payload) {
        try {
            take(source, payload);
        } catch (const bus::NodeFault& fault) {
            return fault.what();
        }
        return "taken";
    }

    void work() {
        while (node.work(out)) {
        }
    }

    std::vector<const schema::RegionPixels*> frames() const {
        std::vector<const schema::RegionPixels*> found;
        for (const Outbox::Sent& s : out.sent) {
            if (s.payload.kind() == Body::RegionPixels) {
                CHECK(s.to == frame_buffer);
                found.push_back(
                    schema::GetMessage(s.payload.bytes().data())->body_as_RegionPixels());
            }
        }
        return found;
    }
    std::vector<std::string> faults() const {
        std::vector<std::string> found;
        for (const Outbox::Sent& s : out.sent) {
            if (s.payload.kind() == Body::Fault) {
                CHECK(s.to == bus::host_id);
                const auto* fault = schema::GetMessage(s.payload.bytes().data())->body_as_Fault();
                CHECK(fault->node() == id);
                found.push_back(std::string(schema::EnumNameFaultCode(fault->code())) + ": " +
                                fault->reason()->str());
            }
        }
        return found;
    }

    bus::NodeId id;
    std::uint64_t sequence = 0;
    Outbox out;
    renderer::RendererNode node;
};

bool is_all(const schema::RegionPixels& pixels, std::size_t tile_number, std::uint32_t colour) {
    const auto* words = pixels.pixels()->data() + tile_number * tile;
    return std::all_of(words, words + tile, [=](std::uint32_t w) { return w == colour; });
}

}  // namespace

TEST_CASE("a frame leaves as one message, with this Renderer's regions in ascending order") {
    Bench bench(1, 2, 1);
    bench.take(first_gp, begin(5, {1, 0, 1, 0}));
    bench.from_gp(0, programs(5, 0, {{2, {{0, 3, sheet(0, 5000)}}}}));
    bench.work();
    const auto frames = bench.frames();
    REQUIRE(frames.size() == 1);
    CHECK(bench.faults().empty());
    CHECK(frames[0]->frame() == 5);
    CHECK(frames[0]->renderer() == 1);
    REQUIRE(frames[0]->tiles()->size() == 2);
    REQUIRE(frames[0]->pixels()->size() == 2 * tile);
    CHECK(frames[0]->tiles()->Get(0)->region() == 0);
    CHECK(frames[0]->tiles()->Get(1)->region() == 2);
    CHECK(is_all(*frames[0], 0, background));
    CHECK(is_all(*frames[0], 1, colours[0]));
    // The sheet adds the ten instructions of a triangle and the shading of its pixels.
    CHECK(frames[0]->tiles()->Get(1)->instructions() >=
          frames[0]->tiles()->Get(0)->instructions() + 10);
    CHECK(frames[0]->tiles()->Get(1)->cycles() > frames[0]->tiles()->Get(0)->cycles());
}

TEST_CASE("a Renderer without regions sends its frame all the same") {
    Bench bench(2, 2, 0);
    bench.take(first_gp, begin(0, {1, 1}));
    bench.from_gp(0, programs(0, 0, {}));
    bench.from_gp(1, programs(0, 1, {}));
    bench.work();
    REQUIRE(bench.frames().size() == 1);
    CHECK(bench.frames()[0]->tiles()->size() == 0);
    CHECK(bench.frames()[0]->pixels()->size() == 0);
}

TEST_CASE("nothing is drawn before the frame has begun and every GP has spoken") {
    Bench bench(2, 1, 0);
    bench.from_gp(1, programs(3, 1, {}));
    CHECK_FALSE(bench.node.work(bench.out));
    bench.take(first_gp, begin(3, {0}));
    CHECK_FALSE(bench.node.work(bench.out));
    bench.from_gp(0, programs(3, 0, {}));
    bench.work();
    CHECK(bench.frames().size() == 1);
    CHECK(bench.faults().empty());
}

TEST_CASE("the order in which GPs' messages arrive changes nothing, and slabs decide ties") {
    const bus::Payload messages[] = {
        begin(1, {0}), programs(1, 0, {{0, {{1, 0, sheet(1, 7000)}}}}),
        programs(1, 1, {{0, {{0, 5, sheet(0, 7000)}, {0, 7, sheet(1, 7000)}}}}),
        programs(1, 2, {{0, {{0, 6, sheet(1, 7000)}}}})};
    const int sources[] = {first_gp, first_gp, first_gp + 1, first_gp + 2};
    int order[] = {0, 1, 2, 3};
    do {
        Bench bench(3, 1, 0);
        for (const int i : order) {
            bench.take(sources[i], messages[i]);
            bench.node.work(bench.out);
        }
        bench.work();
        REQUIRE(bench.frames().size() == 1);
        REQUIRE(bench.faults().empty());
        CHECK(is_all(*bench.frames()[0], 0, colours[0]));
    } while (std::next_permutation(std::begin(order), std::end(order)));
}

TEST_CASE("messages of two frames may interleave; frames leave in ascending order") {
    Bench bench(2, 1, 0);
    bench.from_gp(1, programs(8, 1, {}));
    bench.from_gp(1, programs(9, 1, {{0, {{0, 0, sheet(0, 900)}}}}));
    bench.from_gp(0, begin(8, {0}));
    bench.from_gp(0, programs(8, 0, {{0, {{1, 0, sheet(1, 900)}}}}));
    bench.from_gp(0, begin(9, {0}));
    bench.from_gp(0, programs(9, 0, {}));
    bench.work();
    const auto frames = bench.frames();
    REQUIRE(frames.size() == 2);
    CHECK(bench.faults().empty());
    CHECK(frames[0]->frame() == 8);
    CHECK(is_all(*frames[0], 0, colours[1]));
    CHECK(frames[1]->frame() == 9);
    CHECK(is_all(*frames[1], 0, colours[0]));
}

TEST_CASE("a bad stream is a fault that names its place; the region is drawn without it") {
    Bench bench(2, 1, 0);
    WordList bad = sheet(0, 10);
    bad.push_back(0xEE112233);
    bench.from_gp(0, begin(4, {0}));
    bench.from_gp(0, programs(4, 0, {{0, {{0, 12, bad}}}}));
    bench.from_gp(1, programs(4, 1, {{0, {{1, 3, sheet(1, 4000)}}}}));
    bench.work();
    REQUIRE(bench.frames().size() == 1);
    CHECK(is_all(*bench.frames()[0], 0, colours[1]));
    REQUIRE(bench.faults().size() == 1);
    const std::string fault = bench.faults()[0];
    for (const char* part :
         {"bad_instruction", "frame 4", "GP 0", "region 0", "slab 12", "word 34"}) {
        CAPTURE(fault);
        CHECK(fault.find(part) != std::string::npos);
    }
}

TEST_CASE("segments that do not belong are faults, and the frame is finished") {
    Bench bench(2, 2, 0);
    bench.from_gp(0, begin(4, {0, 1}));
    bench.from_gp(0, programs(4, 0, {{1, {}}, {7, {}}, {0, {{0, 1, sheet(0, 1000)}}}}));
    bench.from_gp(1, programs(4, 1, {{0, {{9, 0, sheet(1, 10)}, {0, 1, sheet(1, 10)}}}}));
    bench.work();
    REQUIRE(bench.frames().size() == 1);
    CHECK(is_all(*bench.frames()[0], 0, colours[0]));
    const std::vector<std::string> faults = bench.faults();
    REQUIRE(faults.size() == 4);
    const auto any = [&](const char* text) {
        return std::any_of(faults.begin(), faults.end(),
                           [&](const std::string& f) { return f.find(text) != std::string::npos; });
    };
    CHECK(any("region 1 is not this Renderer's"));
    CHECK(any("region 7 is not this Renderer's"));
    CHECK(any("surface 9, slab 0: the frame has 2 surfaces"));
    CHECK(any("surface 0, slab 1: GP 0 has drawn this surface and slab already"));
}

TEST_CASE("a flood of bad segments is cut short") {
    Bench bench(1, 1, 0);
    RegionWords flood{0, {}};
    for (std::uint32_t slab = 0; slab < 1000; ++slab) {
        flood.segments.push_back({0, slab, {0xFFFFFFFF}});
    }
    bench.from_gp(0, begin(0, {0}));
    bench.from_gp(0, programs(0, 0, {flood}));
    bench.work();
    CHECK(bench.frames().size() == 1);
    REQUIRE(bench.faults().size() == 16);
    CHECK(bench.faults().back().find("further faults are not told") != std::string::npos);
}

TEST_CASE("messages that cannot be right are refused by name") {
    Bench bench(2, 1, 0);
    CHECK(bench.refused(first_gp, bus::pack(schema::GoT())).find("Go") != std::string::npos);
    CHECK(bench.refused(first_gp, programs(0, 1, {})).find("as GP 1") != std::string::npos);
    CHECK(bench.refused(first_gp, programs(0, 2, {})).find("as GP 2") != std::string::npos);
    bench.from_gp(0, programs(0, 0, {}));
    CHECK(bench.refused(first_gp, programs(0, 0, {})).find("came twice") != std::string::npos);
    bench.from_gp(0, begin(0, {0}));
    CHECK(bench.refused(first_gp, begin(0, {0})).find("begins twice") != std::string::npos);
    bench.from_gp(1, programs(0, 1, {}));
    bench.work();
    CHECK(bench.frames().size() == 1);
    CHECK(bench.refused(first_gp, programs(0, 0, {})).find("it is over") != std::string::npos);
    for (std::uint32_t frame = 1; frame <= 4; ++frame) {
        bench.from_gp(0, begin(frame, {0}));
    }
    CHECK(bench.refused(first_gp, begin(9, {0})).find("the limit is 4") != std::string::npos);
}

TEST_CASE("a frame that lost a message is given up, by name, when a later one is complete") {
    Bench bench(2, 1, 0);
    bench.from_gp(0, begin(1, {0}));
    bench.from_gp(0, programs(1, 0, {}));
    bench.from_gp(0, begin(2, {0}));
    bench.from_gp(0, programs(2, 0, {}));
    bench.from_gp(1, programs(2, 1, {}));
    bench.work();
    REQUIRE(bench.frames().size() == 1);
    CHECK(bench.frames()[0]->frame() == 2);
    REQUIRE(bench.faults().size() == 1);
    CHECK(bench.faults()[0].find("frame 1 is given up") != std::string::npos);
    CHECK(bench.faults()[0].find("1 of 2 GPs") != std::string::npos);
}

TEST_CASE("a topology without this Renderer is refused") {
    Bench bench(1, 1, 0);
    schema::TopologyT topology;
    topology.nodes.push_back(std::make_unique<schema::NodeInfoT>());
    const std::string reason = bench.refused(bus::host_id, bus::pack(topology));
    CHECK(reason.find("node 10 is not a Renderer, 0 GPs, no frame buffer 0") != std::string::npos);
}
