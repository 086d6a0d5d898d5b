// Tests the inspector's answers against the volume itself and the extracted surface, and its
// refusals.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>

#include "host/base/error.hpp"
#include "host/serve/director/inspector.hpp"
#include "tests/system/simulated_machine.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using nlohmann::json;

namespace {

Topology small_machine() {
    Topology topology;
    topology.gp.count = 2;
    topology.renderer.count = 1;
    topology.frame_buffer.count = 1;
    return topology;
}

/// A session with the phantom on a machine in this process.
struct Loaded {
    test::SimulatedMachine machine{small_machine()};
    Session session{machine};
    explicit Loaded(const std::string& phantom) { session.volumes.load(phantom); }
};

std::string refused(Session& session, const std::string& message) {
    try {
        serve::answer(session, message);
    } catch (const RequestError& error) {
        CHECK(error.code == ExitCode::usage);
        return error.what();
    }
    return "";
}

using Place = std::array<int, 2>;  ///< In 1/1000 of a pixel.
Place place_of(double x, double y) {
    return {static_cast<int>(std::lround(1000 * x)), static_cast<int>(std::lround(1000 * y))};
}

/// Ends of a line, in any order.
using Line = std::set<Place>;

/// The mesh's edges that lie in slice k, in voxels.
std::multiset<Line> edges_in_slice(const WeldedMesh& mesh, int k) {
    const auto at = [&](std::uint32_t v) { return mesh.p_grid[v]; };
    std::multiset<Line> lines;
    for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles) {
        for (std::size_t n = 0; n < 3; ++n) {
            const glm::vec3 p = at(triangle[n]), q = at(triangle[(n + 1) % 3]);
            if (p.z == static_cast<float>(k) && q.z == static_cast<float>(k)) {
                lines.insert({place_of(p.x, p.y), place_of(q.x, q.y)});
            }
        }
    }
    return lines;
}

}  // namespace

TEST_SUITE("inspector") {
    TEST_CASE("a slice's bytes are the volume's values, then the contours") {
        Loaded shown("phantom:torus");
        const Volume& volume = shown.session.volumes.volume();
        shown.session.surfaces.set("ring", 30000.5, CaseRule::watertight, {1, 2, 255});
        const serve::Answer answer =
            serve::answer(shown.session, R"({"id":1,"ask":"slice","axis":"y","index":31})");
        const json told = json::parse(answer.json);
        CHECK(told["width"] == volume.nx);
        CHECK(told["height"] == volume.nz);
        CHECK(told["type"] == "uint16");
        CHECK(told["axes"] == json({0, 2, 1}));
        CHECK(told["flips"] == json({false, true}));  // Superior is on top.
        CHECK(told["places_mm"] == json({nullptr, nullptr}));
        CHECK(told["letters"]["right"] == "L");
        REQUIRE(told["contours"].size() == 1);
        CHECK(told["contours"][0]["color"] == "#0102ff");
        CHECK(told["contours"][0]["first"] == 0);

        const auto width = static_cast<std::size_t>(volume.nx);
        const auto height = static_cast<std::size_t>(volume.nz);
        std::uint16_t value = 0, there = 0;
        std::memcpy(&value, answer.bytes.data() + (2 * width + 7) * sizeof value, sizeof value);
        const std::size_t at =
            ((height - 3) * static_cast<std::size_t>(volume.ny) + 31) * width + 7;
        std::memcpy(&there, volume.values.data() + at * sizeof there, sizeof there);
        CHECK(value == there);
        const std::size_t padded = (width * height * 2 + 7) / 8 * 8;
        const auto pieces = told["contours"][0]["count"].get<std::size_t>();
        CHECK(pieces > 50);
        CHECK(answer.bytes.size() == padded + pieces * 4 * sizeof(float));
    }
    TEST_CASE("packed bytes of a slice are smaller, and say how many they were") {
        Loaded shown("phantom:torus");
        shown.session.surfaces.set("ring", 30000.5, CaseRule::watertight, {1, 2, 255});
        for (const char* of :
             {R"("axis":"z","index":12)", R"("axis":"z","index":12,"slab_mm":4,"kind":"mean")"}) {
            const auto asked = [&](const char* packed) {
                return serve::answer(shown.session,
                                     fmt::format(R"({{"ask":"slice",{}{}}})", of, packed));
            };
            const serve::Answer plain = asked(""), packed = asked(R"(,"packed":true)");
            json told = json::parse(packed.json);
            CHECK(told["packed"]["bytes"] == plain.bytes.size());
            CHECK(packed.bytes.size() < plain.bytes.size());
            told.erase("packed");
            CHECK(told == json::parse(plain.json));
            CHECK(asked(R"(,"packed":false)").bytes == plain.bytes);
        }
        CHECK(refused(shown.session, R"({"ask":"slice","axis":"z","index":1,"packed":1})") ==
              "ask: 'packed' is 1; it must be true or false");
    }
    TEST_CASE("a slab's bytes are its values, the contours of its middle, and the middle") {
        Loaded shown("phantom:torus");  // 80 x 64 x 32 voxels of uint16.
        Session& session = shown.session;
        session.surfaces.set("ring", 30000.5, CaseRule::watertight, {1, 2, 255});
        const auto asked = [&](const char* slab) {
            return serve::answer(session,
                                 fmt::format(R"({{"ask":"slice","axis":"z","index":12{}}})", slab));
        };
        const serve::Answer single = asked("");
        const json alone = json::parse(single.json);
        CHECK(!alone.contains("slab"));
        CHECK(asked(R"(,"slab_mm":0)").bytes == single.bytes);
        const std::size_t count = 80 * 64, middle_bytes = 2 * count;
        for (const auto& [kind, bytes] : {std::pair{"mean", 4}, {"max", 2}, {"min", 2}}) {
            CAPTURE(kind);
            const serve::Answer answer =
                asked(fmt::format(R"(,"slab_mm":1e5,"kind":"{}")", kind).c_str());
            const json told = json::parse(answer.json);
            CHECK(told["slab"] == json({{"thickness_mm", 1e5},
                                        {"kind", kind},
                                        {"slices", {0, 31}},
                                        {"type", "uint16"}}));
            CHECK(told["type"] == (bytes == 4 ? "float32" : "uint16"));
            CHECK(told["contours"] == alone["contours"]);
            // Behind the values are the contours and the middle, as in the single slice.
            const std::size_t values = static_cast<std::size_t>(bytes) * count;
            const std::size_t lines = single.bytes.size() - middle_bytes;
            REQUIRE(answer.bytes.size() == values + lines + middle_bytes);
            CHECK(std::memcmp(answer.bytes.data() + values, single.bytes.data() + middle_bytes,
                              lines) == 0);
            CHECK(std::memcmp(answer.bytes.data() + values + lines, single.bytes.data(),
                              middle_bytes) == 0);
        }
        for (const char* wrong : {"-1", "1e7", "\"3\"", "null"}) {
            CHECK(refused(session, fmt::format(R"({{"ask":"slice","axis":"z","index":1,)"
                                               R"("slab_mm":{},"kind":"max"}})",
                                               wrong))
                      .ends_with("; it must be a number from 0 to 1000000"));
        }
        CHECK(refused(session, R"({"ask":"slice","axis":"z","index":1,"slab_mm":2})") ==
              R"(ask: 'kind' is missing; it must be "mean", "max" or "min")");
        CHECK(refused(session, R"({"ask":"slice","axis":"z","index":1,"slab_mm":2,"kind":"a"})") ==
              R"(ask: 'kind' is "a"; it must be "mean", "max" or "min")");
    }
    TEST_CASE("contours are the edges of the surface that lie in the slice") {
        Loaded shown("phantom:pelvis");
        for (const CaseRule table : {CaseRule::watertight, CaseRule::asymptotic}) {
            shown.session.surfaces.set("bone", 250.5, table, {1, 2, 3});
            const WeldedMesh mesh = shown.session.meshes.fetch("bone");
            const serve::Answer answer =
                serve::answer(shown.session, R"({"ask":"slice","axis":"z","index":30})");
            const json told = json::parse(answer.json);
            std::multiset<Line> contours;
            const auto count = told["contours"][0]["count"].get<std::size_t>();
            std::vector<float> points(4 * count);
            std::memcpy(points.data(), answer.bytes.data() + answer.bytes.size() - 16 * count,
                        16 * count);
            for (std::size_t i = 0; i < points.size(); i += 4) {
                Line line = {place_of(points[i], points[i + 1]),
                             place_of(points[i + 2], points[i + 3])};
                // Each edge belongs to a triangle above and to one below.
                contours.insert(line);
                contours.insert(std::move(line));
            }
            CHECK(count > 200);
            CHECK(contours == edges_in_slice(mesh, 30));
        }
    }
    TEST_CASE("hidden surfaces have no contours") {
        Loaded shown("phantom:torus");
        shown.session.surfaces.set("ring", 30000.5, CaseRule::watertight, {1, 2, 3});
        shown.session.scene.surfaces[0].visible = false;
        const serve::Answer answer =
            serve::answer(shown.session, R"({"ask":"slice","axis":"z","index":10})");
        CHECK(json::parse(answer.json)["contours"].empty());
    }
    TEST_CASE("an oblique slice has sampled values, then its contours") {
        Loaded shown("phantom:sphere");
        Session& session = shown.session;
        session.surfaces.set("ball", 0.5, CaseRule::watertight, {1, 2, 255});
        const auto question = [](const char* right, const char* down, const char* size) {
            return fmt::format(R"({{"ask":"slice","axis":"oblique","center_mm":[0.3,-0.7,0.45],)"
                               R"("right":{},"down":{},"width":{},"height":90,"pixel_mm":0.75}})",
                               right, down, size);
        };
        const serve::Answer answer =
            serve::answer(session, question("[0.6,0.8,0]", "[0,0,-1]", "100"));
        const json told = json::parse(answer.json);
        CHECK(told["width"] == 100);
        CHECK(told["height"] == 90);
        CHECK(told["type"] == "float32");
        CHECK(told["spacing_mm"] == json({0.75, 0.75}));
        CHECK(told["letters"]["top"] == "S");
        CHECK(told["letters"]["right"] == "PL");
        const auto pieces = told["contours"][0]["count"].get<std::size_t>();
        CHECK(told["contours"][0]["isovalue"] == 0.5);
        CHECK(pieces > 100);
        CHECK(answer.bytes.size() == 100 * 90 * 4 + pieces * 16);
        float middle = 0;  // 0.5 pixels beside the center of the sphere, in 0.01 mm of depth.
        std::memcpy(&middle, answer.bytes.data() + 4 * (45 * 100 + 50), sizeof middle);
        CHECK(middle > 3000 - 100 * 2.7F);  // A voxel has a diagonal of 2.62 mm.
        CHECK(middle <= 3000);
        CHECK(refused(session, question("[1,1,0]", "[0,0,-1]", "100")) ==
              "ask: 'right' is [1,1,0] and 'down' is [0,0,-1]; they must have the length 1 and be "
              "at a right angle");
        CHECK(refused(session, question("[1,0]", "[0,0,-1]", "100")) ==
              "ask: 'right' is [1,0]; it must be three numbers from -1000000 to 1000000");
        CHECK(refused(session, question("[1,0,0]", "[0,1,0]", "2000")) ==
              "ask: 'width' is 2000; it must be a whole number from 2 to 1024");
    }
    TEST_CASE("bad questions are refused with what was given and what may be") {
        Loaded shown("phantom:torus");  // 80 x 64 x 32 voxels.
        Session& session = shown.session;
        CHECK(refused(session, "[1]") == "ask: the message is no JSON object");
        CHECK(refused(session, "{\"ask\"") == "ask: the message is no JSON object");
        const std::string may_be =
            R"(; it must be "slice", "scrub", "folder", "series" or "attributes")";
        CHECK(refused(session, "{}") == "ask: 'ask' is missing" + may_be);
        CHECK(refused(session, R"({"ask":"pie"})") == R"(ask: 'ask' is "pie")" + may_be);
        CHECK(refused(session, R"({"ask":["slice"]})") == R"(ask: 'ask' is ["slice"])" + may_be);
        CHECK(refused(session, R"({"ask":"slice","axis":"w","index":0})") ==
              R"(ask: 'axis' is "w"; it must be "x", "y", "z" or "oblique")");
        CHECK(refused(session, R"({"ask":"slice","axis":"xy","index":0})") ==
              R"(ask: 'axis' is "xy"; it must be "x", "y", "z" or "oblique")");
        CHECK(refused(session, R"({"ask":"slice","axis":"","index":0})") ==
              R"(ask: 'axis' is ""; it must be "x", "y", "z" or "oblique")");
        CHECK(refused(session, R"({"ask":"slice","axis":2,"index":0})") ==
              R"(ask: 'axis' is 2; it must be "x", "y", "z" or "oblique")");
        for (const char* index : {"32", "-1", "1.5", "\"3\"", "null", "18446744073709551615"}) {
            CHECK(refused(session,
                          fmt::format(R"({{"ask":"slice","axis":"z","index":{}}})", index)) ==
                  fmt::format("ask: 'index' is {}; it must be a whole number from 0 to 31", index));
        }
        CHECK(refused(session, R"({"ask":"scrub","x":512,"y":0,"at":0})") ==
              "ask: 'x' is 512; it must be a whole number from 0 to 511");
        CHECK(refused(session, R"({"ask":"scrub","x":0,"at":0})") ==
              "ask: 'y' is missing; it must be a whole number from 0 to 511");
        const std::string longer = refused(session, R"({"ask":")" + std::string(999, 'a') + "\"}");
        CHECK(longer.size() < 130);
    }
    TEST_CASE("a binary answer is header, JSON, and bytes from a multiple of 8 on") {
        const serve::Answer answer{"{\"a\":1}", {std::byte{7}, std::byte{8}}};
        const std::string message = serve::answer_message(0x01020304, answer);
        std::array<std::uint32_t, 4> header{};
        std::memcpy(header.data(), message.data(), sizeof header);
        CHECK(header == std::array<std::uint32_t, 4>{0x4e413550, 0x01020304, 7, 0});
        CHECK(std::memcmp(message.data(), "P5AN", 4) == 0);
        CHECK(std::memcmp(message.data() + 16, "{\"a\":1}\0", 8) == 0);
        CHECK(message.size() == 26);
        CHECK(message[24] == 7);
    }
}
