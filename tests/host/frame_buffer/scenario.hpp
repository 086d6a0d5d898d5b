// Frames with all their regions, and a frame buffer driven by hand.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "host/frame_buffer/node.hpp"
#include "tests/random_seed.hpp"

namespace pxpl5::test {

namespace schema = bus::schema;

inline constexpr int side = 128;
inline constexpr std::uint32_t opaque = 0xff000000;
inline constexpr bus::NodeId master_gp = 1, first_renderer = 10, frame_buffer = 99;

/// Which frame buffer of how many is driven.
struct FrameBufferPlace {
    int index = 0, count = 1;
};

struct Outbox final : bus::Outbox {
    using bus::Outbox::send;
    void send(bus::NodeId to, bus::Payload payload) override {
        CHECK(to == bus::host_id);
        if (is_full) {
            throw bus::NodeFault(schema::FaultCode::out_of_memory, "the host is full");
        }
        sent.push_back(std::move(payload));
    }
    std::vector<bus::Payload> sent;
    bool is_full = false;  ///< Sending throws.
};

inline bus::Message delivered(bus::NodeId source, const bus::Payload& payload) {
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
struct FrameBufferBench {
    explicit FrameBufferBench(int renderers, const FrameBufferPlace& place = {}) {
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
        for (int i = 0; i < place.count; ++i) {
            add(static_cast<bus::NodeId>(frame_buffer + i - place.index),
                schema::Role::frame_buffer, i);
        }
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
    bool read_depths = false;
    std::uint8_t sample = 0, samples = 1;

    int columns() const { return (width + side - 1) / side; }
    int rows() const { return (height + side - 1) / side; }

    bus::Payload begin(bool read_back = true) const {
        schema::BeginFrameT message;
        message.draw = std::make_unique<schema::DrawFrameT>();
        message.draw->frame = frame;
        message.draw->width = static_cast<std::uint32_t>(width);
        message.draw->height = static_cast<std::uint32_t>(height);
        message.draw->read_back = read_back;
        message.draw->read_depths = read_depths;
        message.draw->sample = sample;
        message.draw->samples = samples;
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

    /// place  The frame buffer that the tiles are for.
    schema::RegionPixelsT tiles(int renderer, const FrameBufferPlace& place = {}) const {
        schema::RegionPixelsT message;
        message.frame = frame;
        message.renderer = static_cast<std::uint16_t>(renderer);
        // Last region first: the order within a message is the Renderer's own.
        for (std::size_t r = regions.size(); r-- > 0;) {
            if (assignment[r] == renderer && view_of(r) % place.count == place.index) {
                const bool has_depths = read_depths && is_drawn(r);
                message.tiles.emplace_back(static_cast<std::uint16_t>(r), has_depths, cycles[r],
                                           3 * cycles[r]);
                message.pixels.insert(message.pixels.end(), regions[r].begin(), regions[r].end());
                for (std::size_t i = 0; has_depths && i < regions[r].size(); ++i) {
                    message.depths.push_back(depth_of(regions[r][i]));
                }
            }
        }
        return message;
    }
    bus::Payload pixels(int renderer, const FrameBufferPlace& place = {}) const {
        flatbuffers::FlatBufferBuilder body;
        const schema::RegionPixelsT message = tiles(renderer, place);
        const auto sent = body.CreateVectorOfStructs(message.tiles);
        const auto words = body.CreateVector(message.pixels);
        // Present if the frame reads them, even if no region has any. bus::pack() drops them then.
        const auto depths = read_depths ? body.CreateVector(message.depths) : 0;
        return bus::finish(body, schema::CreateRegionPixels(body, message.frame, message.renderer,
                                                            sent, words, depths));
    }
    int view_of(std::size_t region) const {
        return static_cast<int>(region) / (columns() * rows());
    }

    /// Pixel by pixel from the definition: regions row by row from the top left, then the views.
    std::vector<std::uint32_t> expected() const {
        std::vector<std::uint32_t> picture = words();
        std::ranges::transform(picture, picture.begin(),
                               [](std::uint32_t word) { return opaque | word; });
        return picture;
    }
    /// Here depths are made from pixels, with any bit set or clear.
    static std::uint32_t depth_of(std::uint32_t pixel) { return pixel * 0x9E3779B1U; }
    /// Every third region shows the background only: its depths are not sent.
    static bool is_drawn(std::size_t region) { return region % 3 != 1; }
    std::vector<std::uint32_t> expected_depths() const {
        return words([](std::size_t region, std::uint32_t pixel) {
            return is_drawn(region) ? depth_of(pixel) : 0xFFFF'FF00;
        });
    }
    std::vector<std::uint32_t> words(
        const std::function<std::uint32_t(std::size_t, std::uint32_t)>& word_of =
            [](std::size_t, std::uint32_t pixel) { return pixel; }) const {
        std::vector<std::uint32_t> picture;
        for (int view = 0; view < views; ++view) {
            for (int y = 0; y < height; ++y) {
                for (int x = 0; x < width; ++x) {
                    const int region = (view * rows() + y / side) * columns() + x / side;
                    const int pixel = y % side * side + x % side;
                    const auto r = static_cast<std::size_t>(region);
                    picture.push_back(word_of(r, regions[r][static_cast<std::size_t>(pixel)]));
                }
            }
        }
        return picture;
    }
};

struct Shape {
    int width, height, views;
};

inline Scenario random_scenario(std::mt19937& random, std::uint32_t frame, Shape shape,
                                int renderers) {
    Scenario scenario;
    scenario.frame = frame;
    scenario.width = shape.width;
    scenario.height = shape.height;
    scenario.views = shape.views;
    scenario.renderers = renderers;
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

inline std::uint32_t seed() {
    return test::seed_or<std::uint32_t>(5);
}

inline std::vector<std::uint32_t> picture_of(const bus::Payload& payload) {
    const auto* pixels = FrameBufferBench::frame_done(payload).pixels();
    REQUIRE(pixels != nullptr);
    return {pixels->begin(), pixels->end()};
}

inline bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace pxpl5::test
