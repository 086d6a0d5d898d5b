#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "host/frame_buffer/node.hpp"

using namespace pxpl5;
namespace schema = bus::schema;

namespace {

constexpr int side = 128;
constexpr std::uint32_t opaque = 0xff000000;
constexpr bus::NodeId master_gp = 1, first_renderer = 10, frame_buffer = 99;

struct Outbox final : bus::Outbox {
    using bus::Outbox::send;
    void send(bus::NodeId to, bus::Payload payload) override {
        CHECK(to == bus::host_id);
        sent.push_back(std::move(payload));
    }
    std::vector<bus::Payload> sent;
};

bus::Message delivered(bus::NodeId source, const bus::Payload& payload) {
    schema::Header header;
    header.mutate_magic(bus::header_magic);
    header.mutate_version(bus::protocol_version);
    header.mutate_kind(static_cast<std::uint16_t>(payload.kind()));
    header.mutate_source(source);
    header.mutate_destination(frame_buffer);
    header.mutate_body_bytes(payload.bytes().size());
    const auto copy = std::make_shared<std::vector<std::uint64_t>>(payload.bytes().size() / 8 + 1);
    std::memcpy(copy->data(), payload.bytes().data(), payload.bytes().size());
    return {header,
            {reinterpret_cast<const std::uint8_t*>(copy->data()), payload.bytes().size()},
            copy};
}

/// A frame buffer among `renderers` Renderers, driven by hand.
struct Bench {
    explicit Bench(int renderers) {
        schema::TopologyT topology;
        const auto add = [&topology](bus::NodeId id, schema::Role role, int index) {
            auto info = std::make_unique<schema::NodeInfoT>();
            info->id = id;
            info->role = role;
            info->index = static_cast<std::uint16_t>(index);
            topology.nodes.push_back(std::move(info));
        };
        add(bus::host_id, schema::Role::host, 0);
        add(master_gp, schema::Role::gp, 0);
        for (int i = 0; i < renderers; ++i) {
            add(static_cast<bus::NodeId>(first_renderer + i), schema::Role::renderer, i);
        }
        add(frame_buffer, schema::Role::frame_buffer, 0);
        node.receive(delivered(bus::host_id, bus::pack(topology)), out);
    }

    void take(bus::NodeId source, const bus::Payload& payload) {
        node.receive(delivered(source, payload), out);
    }
    void from_renderer(int index, const bus::Payload& payload) {
        take(static_cast<bus::NodeId>(first_renderer + index), payload);
    }
    /// The text of the fault that this message causes; "no fault" if it causes none.
    std::string fault(bus::NodeId source, const bus::Payload& payload) {
        try {
            take(source, payload);
        } catch (const bus::NodeFault& error) {
            return error.what();
        }
        return "no fault";
    }
    /// The frames that were finished so far.
    std::vector<std::uint32_t> done() const {
        std::vector<std::uint32_t> frames;
        for (const bus::Payload& payload : out.sent) {
            frames.push_back(frame_done(payload).frame());
        }
        return frames;
    }
    static const schema::FrameDone& frame_done(const bus::Payload& payload) {
        REQUIRE(payload.kind() == schema::Body::FrameDone);
        return *schema::GetMessage(payload.bytes().data())->body_as_FrameDone();
    }

    host::FrameBufferNode node;
    Outbox out;
};

/// A frame with all its finished regions, and what the frame buffer must make of them.
struct Scenario {
    std::uint32_t frame = 0;
    int width = 0, height = 0, views = 1, renderers = 1;
    std::vector<std::uint16_t> assignment;
    std::vector<std::vector<std::uint32_t>> regions;  ///< By region, 128 * 128.
    std::vector<std::uint64_t> cycles;                ///< By region.

    int columns() const { return (width + side - 1) / side; }
    int rows() const { return (height + side - 1) / side; }

    bus::Payload begin(bool read_back = true) const {
        schema::BeginFrameT message;
        message.draw = std::make_unique<schema::DrawFrameT>();
        message.draw->frame = frame;
        message.draw->width = static_cast<std::uint32_t>(width);
        message.draw->height = static_cast<std::uint32_t>(height);
        message.draw->read_back = read_back;
        message.draw->specular_power = 1;
        for (int i = 0; i < views; ++i) {
            auto view = std::make_unique<schema::ViewT>();
            view->voxel_to_eye = std::make_unique<schema::Matrix>();
            view->projection = std::make_unique<schema::Matrix>();
            message.draw->views.push_back(std::move(view));
        }
        message.assignment = assignment;
        return bus::pack(message);
    }

    schema::RegionPixelsT tiles(int renderer) const {
        schema::RegionPixelsT message;
        message.frame = frame;
        message.renderer = static_cast<std::uint16_t>(renderer);
        // Last region first: the order within a message is the Renderer's own.
        for (std::size_t r = regions.size(); r-- > 0;) {
            if (assignment[r] == renderer) {
                message.tiles.emplace_back(static_cast<std::uint16_t>(r), cycles[r], 3 * cycles[r]);
                message.pixels.insert(message.pixels.end(), regions[r].begin(), regions[r].end());
            }
        }
        return message;
    }
    bus::Payload pixels(int renderer) const { return bus::pack(tiles(renderer)); }

    /// Pixel by pixel from the definition: regions row by row from the top left, then the views.
    std::vector<std::uint32_t> expected() const {
        std::vector<std::uint32_t> picture;
        for (int view = 0; view < views; ++view) {
            for (int y = 0; y < height; ++y) {
                for (int x = 0; x < width; ++x) {
                    const int region = (view * rows() + y / side) * columns() + x / side;
                    const int pixel = y % side * side + x % side;
                    picture.push_back(
                        opaque |
                        regions[static_cast<std::size_t>(region)][static_cast<std::size_t>(pixel)]);
                }
            }
        }
        return picture;
    }
};

struct Shape {
    int width, height, views;
};

Scenario random_scenario(std::mt19937& random, std::uint32_t frame, Shape shape, int renderers) {
    Scenario scenario{frame, shape.width, shape.height, shape.views, renderers, {}, {}, {}};
    const int count = scenario.columns() * scenario.rows() * scenario.views;
    for (int r = 0; r < count; ++r) {
        scenario.assignment.push_back(
            static_cast<std::uint16_t>(random() % static_cast<unsigned>(renderers)));
        scenario.cycles.push_back(random());
        auto& region = scenario.regions.emplace_back(side * side);
        std::generate(region.begin(), region.end(), [&random] { return random() & 0x00ffffffU; });
    }
    return scenario;
}

std::uint32_t seed() {
    const char* given = std::getenv("PXPL5_SEED");
    return given != nullptr ? static_cast<std::uint32_t>(std::stoul(given)) : 5;
}

std::vector<std::uint32_t> picture_of(const bus::Payload& payload) {
    const auto* pixels = Bench::frame_done(payload).pixels();
    REQUIRE(pixels != nullptr);
    return {pixels->begin(), pixels->end()};
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE(
    "a frame is its regions in their places, cropped at the edges, one view below the other") {
    std::mt19937 random(seed());
    CAPTURE(seed());
    const std::array shapes = {Shape{256, 128, 1}, Shape{300, 200, 1}, Shape{1, 1, 1},
                               Shape{129, 127, 2}, Shape{512, 512, 2}};
    for (const Shape shape : shapes) {
        for (const int renderers : {1, 3}) {
            CAPTURE(shape.width);
            CAPTURE(renderers);
            const Scenario frame = random_scenario(random, 7, shape, renderers);
            Bench bench(renderers);
            bench.take(master_gp, frame.begin());
            std::vector<int> order;
            for (int i = 0; i < renderers; ++i) {
                order.push_back(i);
            }
            std::shuffle(order.begin(), order.end(), random);
            for (const int i : order) {
                CHECK(bench.done().empty());
                bench.from_renderer(i, frame.pixels(i));
            }
            REQUIRE(bench.done() == std::vector<std::uint32_t>{7});
            CHECK(picture_of(bench.out.sent[0]) == frame.expected());
        }
    }
}

TEST_CASE("a finished frame says its size, its cycles by region and the sum of instructions") {
    std::mt19937 random(seed());
    const Scenario frame = random_scenario(random, 0, {300, 200, 2}, 3);
    Bench bench(3);
    bench.take(master_gp, frame.begin(false));
    for (int i = 0; i < 3; ++i) {
        bench.from_renderer(i, frame.pixels(i));
    }
    REQUIRE(bench.out.sent.size() == 1);
    const schema::FrameDone& done = Bench::frame_done(bench.out.sent[0]);
    CHECK(done.frame() == 0);
    CHECK(done.width() == 300);
    CHECK(done.height() == 200);
    CHECK(done.views() == 2);
    CHECK(std::vector<std::uint64_t>(done.region_cycles()->begin(), done.region_cycles()->end()) ==
          frame.cycles);
    std::uint64_t cycles = 0;
    for (const std::uint64_t c : frame.cycles) {
        cycles += c;
    }
    CHECK(done.instructions() == 3 * cycles);
    CHECK_MESSAGE(done.pixels() == nullptr, "pixels travel only when asked for");
}

TEST_CASE("regions may overtake their BeginFrame, and two frames may interleave") {
    std::mt19937 random(seed());
    const Scenario first = random_scenario(random, 4, {300, 200, 1}, 2);
    const Scenario second = random_scenario(random, 6, {130, 129, 2}, 2);
    Bench bench(2);
    bench.from_renderer(1, first.pixels(1));
    bench.from_renderer(1, second.pixels(1));
    bench.take(master_gp, first.begin());
    bench.take(master_gp, second.begin());
    CHECK(bench.done().empty());
    bench.from_renderer(0, first.pixels(0));
    CHECK(bench.done() == std::vector<std::uint32_t>{4});
    bench.from_renderer(0, second.pixels(0));
    REQUIRE(bench.done() == std::vector<std::uint32_t>{4, 6});
    CHECK(picture_of(bench.out.sent[0]) == first.expected());
    CHECK(picture_of(bench.out.sent[1]) == second.expected());
}

TEST_CASE("a frame is finished at its BeginFrame if all its regions overtook it") {
    std::mt19937 random(seed());
    const Scenario frame = random_scenario(random, 1, {200, 100, 1}, 2);
    Bench bench(2);
    bench.from_renderer(0, frame.pixels(0));
    bench.from_renderer(1, frame.pixels(1));
    bench.take(master_gp, frame.begin());
    REQUIRE(bench.done() == std::vector<std::uint32_t>{1});
    CHECK(picture_of(bench.out.sent[0]) == frame.expected());
}

TEST_CASE("many frames of changing size, in any arrival order, are each right") {
    std::mt19937 random(seed());
    CAPTURE(seed());
    constexpr int renderers = 4;
    Bench bench(renderers);
    for (std::uint32_t k = 0; k < 20; k += 2) {
        std::array<Scenario, 2> pair;
        for (std::uint32_t i = 0; i < 2; ++i) {
            const Shape shape{1 + static_cast<int>(random() % 300),
                              1 + static_cast<int>(random() % 300),
                              1 + static_cast<int>(random() % 2)};
            pair[i] = random_scenario(random, k + i, shape, renderers);
        }
        // Each sender's own messages stay in order; between senders anything goes.
        std::vector<int> senders;
        for (int sender = 0; sender <= renderers; ++sender) {
            senders.insert(senders.end(), {sender, sender});
        }
        std::shuffle(senders.begin(), senders.end(), random);
        std::array<std::size_t, renderers + 1> sent{};
        for (const int sender : senders) {
            const Scenario& frame = pair[sent[static_cast<std::size_t>(sender)]++];
            if (sender == renderers) {
                bench.take(master_gp, frame.begin());
            } else {
                bench.from_renderer(sender, frame.pixels(sender));
            }
        }
        REQUIRE(bench.out.sent.size() == k + 2);
        CHECK(picture_of(bench.out.sent[k]) == pair[0].expected());
        CHECK(picture_of(bench.out.sent[k + 1]) == pair[1].expected());
    }
}

TEST_CASE("a frame that a Renderer failed to send does not hold up the next") {
    std::mt19937 random(seed());
    const Scenario lost = random_scenario(random, 1, {200, 100, 1}, 2);
    const Scenario next = random_scenario(random, 2, {200, 100, 1}, 2);
    Bench bench(2);
    bench.take(master_gp, lost.begin());
    bench.from_renderer(0, lost.pixels(0));
    bench.take(master_gp, next.begin());
    bench.from_renderer(0, next.pixels(0));
    CHECK(bench.done().empty());
    bench.from_renderer(1, next.pixels(1));
    REQUIRE(bench.done() == std::vector<std::uint32_t>{2});
    CHECK(picture_of(bench.out.sent[0]) == next.expected());
    const std::string late = bench.fault(first_renderer + 1, lost.pixels(1));
    CHECK_MESSAGE(late == "frame 1, Renderer 1: its regions come late, the frame is over", late);
}

TEST_CASE("regions that do not belong are named faults, and the frame can still be finished") {
    std::mt19937 random(seed());
    const Scenario frame = random_scenario(random, 3, {300, 300, 1}, 2);
    Bench bench(2);
    bench.take(master_gp, frame.begin());

    const auto refused = [&](const schema::RegionPixelsT& tiles, bus::NodeId source,
                             const std::string& reason) {
        const std::string fault = bench.fault(source, bus::pack(tiles));
        CHECK_MESSAGE(fault == reason, fault);
    };
    const auto edited = [&](auto edit) {
        schema::RegionPixelsT tiles = frame.tiles(0);
        REQUIRE(tiles.tiles.size() >= 2);
        edit(tiles);
        return tiles;
    };
    const auto mine = std::to_string(frame.tiles(0).tiles[0].region());
    const auto other = std::to_string(frame.tiles(1).tiles[0].region());
    const auto count = frame.tiles(0).tiles.size();

    refused(edited([](auto& t) { t.tiles[0].mutate_region(9); }), first_renderer,
            "frame 3, Renderer 0: region 9, the frame has 9");
    refused(edited([&](auto& t) { t.tiles[0] = frame.tiles(1).tiles[0]; }), first_renderer,
            "frame 3, Renderer 0: region " + other + " is Renderer 1's");
    refused(edited([](auto& t) { t.tiles[1] = t.tiles[0]; }), first_renderer,
            "frame 3, Renderer 0: region " + mine + " came twice");
    refused(edited([](auto& t) {
                t.tiles.pop_back();
                t.pixels.resize(t.pixels.size() - side * side);
            }),
            first_renderer,
            "frame 3, Renderer 0: " + std::to_string(count - 1) + " regions, " +
                std::to_string(count) + " are assigned to it");
    refused(frame.tiles(0), first_renderer + 1,
            "frame 3: node 11 sends regions as Renderer 0, of 2 Renderers");
    refused(edited([](auto& t) { t.renderer = 2; }), first_renderer,
            "frame 3: node 10 sends regions as Renderer 2, of 2 Renderers");

    bench.from_renderer(0, frame.pixels(0));
    refused(frame.tiles(0), first_renderer, "frame 3, Renderer 0: its regions came twice");
    bench.from_renderer(1, frame.pixels(1));
    REQUIRE(bench.done() == std::vector<std::uint32_t>{3});
    CHECK(picture_of(bench.out.sent[0]) == frame.expected());
    refused(frame.tiles(0), first_renderer,
            "frame 3, Renderer 0: its regions come late, the frame is over");
}

TEST_CASE("a BeginFrame that makes no sense is a named fault") {
    std::mt19937 random(seed());
    const Scenario frame = random_scenario(random, 3, {300, 300, 1}, 2);
    Bench bench(2);
    const auto refused = [&](auto edit, const std::string& reason) {
        Scenario bad = frame;
        edit(bad);
        const std::string fault = bench.fault(master_gp, bad.begin());
        CHECK_MESSAGE(has(fault, reason), fault);
    };
    refused([](Scenario& s) { s.assignment[4] = 2; },
            "region 4 is assigned to Renderer 2, there are 2");
    bench.take(master_gp, frame.begin());
    CHECK(has(bench.fault(master_gp, frame.begin()), "frame 3 begins after frame 3"));
    CHECK(has(bench.fault(bus::host_id, bus::pack(schema::SetSurfaceT{})),
              "a frame buffer does not take SetSurface"));
}

TEST_CASE("regions of frames that never begin are refused once their number is out of bounds") {
    std::mt19937 random(seed());
    Bench bench(1);
    std::string fault = "no fault";
    int held = 0;
    for (; held < 100 && fault == "no fault"; ++held) {
        const Scenario frame =
            random_scenario(random, static_cast<std::uint32_t>(held), {8, 8, 1}, 1);
        fault = bench.fault(first_renderer, frame.pixels(0));
    }
    CHECK(held < 100);
    CHECK_MESSAGE(has(fault, "the frame is unknown"), fault);
}
