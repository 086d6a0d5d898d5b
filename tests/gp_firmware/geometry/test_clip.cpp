#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "gp_firmware/geometry/clip.hpp"

using namespace pxpl5::gp;

namespace {

Camera flat_camera() {
    Camera c;
    c.width_px = c.height_px = 1024;
    c.projection = glm::ortho(0.0, 1024.0, 1024.0, 0.0, -100.0, 100.0);
    return c;
}

Vertex vertex(float x, float y, float z) {
    return {{x, y, z}, {0, 0, 32767}, 0};
}

std::vector<ScreenVertex> clipped(const std::array<Vertex, 3>& t, const Camera& camera) {
    const Projection projection = prepare(camera);
    const auto screen = transformed(t, projection);
    std::vector<ScreenVertex> polygon;
    clip_triangle({&t[0], &t[1], &t[2]}, {&screen[0], &screen[1], &screen[2]}, projection, polygon);
    return polygon;
}

/// Signed area in 1/256 px^2.
double area(const std::vector<ScreenVertex>& polygon) {
    double twice = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const ScreenVertex &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
        twice += static_cast<double>(p.x) * q.y - static_cast<double>(q.x) * p.y;
    }
    return twice / 2;
}

bool has(const std::vector<ScreenVertex>& polygon, int x, int y) {
    for (const ScreenVertex& v : polygon) {
        if (v.x == x && v.y == y) {
            return true;
        }
    }
    return false;
}

bool has_own(const std::vector<ScreenVertex>& polygon, const ScreenVertex& own) {
    return std::ranges::any_of(polygon, [&](const ScreenVertex& v) {
        return v.x == own.x && v.y == own.y && v.z == own.z && v.nx == own.nx && v.ny == own.ny &&
               v.nz == own.nz;
    });
}

}  // namespace

TEST_SUITE("gp/clip") {
    TEST_CASE("a triangle inside stays as it is") {
        const auto polygon =
            clipped({vertex(10, 10, 0), vertex(90, 20, 5), vertex(30, 80, -5)}, flat_camera());
        REQUIRE(polygon.size() == 3);
        CHECK(polygon[0].x == 160);
        CHECK(polygon[1].y == 320);
        CHECK(polygon[2].x == 480);
    }

    TEST_CASE("a plane and its opposite share a triangle's area between them") {
        std::mt19937 engine(11);
        std::uniform_real_distribution<float> place(50, 950), tilt(-1, 1);
        for (int i = 0; i < 300; ++i) {
            const std::array<Vertex, 3> t = {vertex(place(engine), place(engine), 10),
                                             vertex(place(engine), place(engine), -10),
                                             vertex(place(engine), place(engine), 0)};
            Camera c = flat_camera();
            const double whole = area(clipped(t, c));
            const double a = tilt(engine), b = tilt(engine);
            const glm::dvec4 plane(a, b, 0, -a * 500 - b * 500);
            c.clip_planes = {plane};
            const double kept = area(clipped(t, c));
            c.clip_planes = {-plane};
            const double other = area(clipped(t, c));
            // Two new corners snapped, each by half a step at most, over 16 * 1300 steps.
            CHECK(std::abs(kept + other - whole) < 2.0 * 16 * 1300);
            CHECK(kept * whole >= 0);
            CHECK(other * whole >= 0);
        }
    }

    TEST_CASE("half of a square is kept, to the step") {
        Camera c = flat_camera();
        c.clip_planes = {{1, 0, 0, -100}};
        const auto lower = clipped({vertex(50, 50, 0), vertex(150, 50, 0), vertex(150, 150, 0)}, c);
        const auto upper = clipped({vertex(50, 50, 0), vertex(150, 150, 0), vertex(50, 150, 0)}, c);
        CHECK(std::abs(area(lower)) + std::abs(area(upper)) == 50 * 100 * 256);
        CHECK(has(lower, 1600, 800));
        CHECK(has(lower, 1600, 1600));
        CHECK(has(upper, 1600, 1600));
        CHECK(has(upper, 1600, 2400));
    }

    TEST_CASE("triangles that share an edge get the same new corner on it") {
        std::mt19937 engine(12);
        std::uniform_real_distribution<float> place(0, 1000), deep(-300, 300), tilt(-1, 1);
        int crossings = 0;
        for (int i = 0; i < 2000; ++i) {
            const Vertex p = vertex(place(engine), place(engine), deep(engine));
            const Vertex q = vertex(place(engine), place(engine), deep(engine));
            const Vertex r = vertex(place(engine), place(engine), deep(engine));
            const Vertex s = vertex(place(engine), place(engine), deep(engine));
            Camera c = flat_camera();
            const double a = tilt(engine), b = tilt(engine), d = tilt(engine);
            c.clip_planes = {{a, b, d, -a * 500 - b * 500}, {b, d, a, -b * 300 - d * 600}};
            // The shared edge as a triangle without area: only its own corners and crossings.
            const auto edge = clipped({p, q, q}, c);
            for (const auto& side : {clipped({p, q, r}, c), clipped({q, p, s}, c)}) {
                for (const ScreenVertex& v : edge) {
                    CHECK(has(side, v.x, v.y));
                    ++crossings;
                }
            }
        }
        CHECK(crossings > 1000);
    }

    TEST_CASE("a crossing half-way between two steps goes to the same step from both sides") {
        // The plane lies where rounding is a toss: only the same operands give the same answer.
        std::mt19937 engine(14);
        std::uniform_real_distribution<float> left(10, 400), right(600, 1000), place(10, 1000);
        std::uniform_int_distribution<int> step(450 * 16, 550 * 16);
        for (int i = 0; i < 3000; ++i) {
            const Vertex p = vertex(left(engine), place(engine), 0);
            const Vertex q = vertex(right(engine), place(engine), 0);
            const Vertex r = vertex(place(engine), place(engine), 0);
            Camera c = flat_camera();
            c.clip_planes = {{1, 0, 0, -(step(engine) + 0.5) / 16}};
            for (const ScreenVertex& v : clipped({p, q, q}, c)) {
                CHECK(has(clipped({q, p, r}, c), v.x, v.y));
                CHECK(has(clipped({p, q, r}, c), v.x, v.y));
            }
        }
    }

    TEST_CASE(
        "every corner that leaves is within the view, and unclipped ones are the mesh's own") {
        std::mt19937 engine(13);
        std::uniform_real_distribution<float> anywhere(-3000, 3000);
        Camera c;
        c.width_px = 640;
        c.height_px = 480;
        c.projection = glm::perspective(1.0, 640.0 / 480.0, 1.0, 2000.0);
        std::size_t longest = 0;
        for (int i = 0; i < 5000; ++i) {
            const std::array<Vertex, 3> t = {
                vertex(anywhere(engine), anywhere(engine), anywhere(engine)),
                vertex(anywhere(engine) * 100, anywhere(engine), anywhere(engine)),
                vertex(anywhere(engine), anywhere(engine) * 100, anywhere(engine))};
            const auto polygon = clipped(t, c);
            const auto screen = transformed(t, prepare(c));
            for (const ScreenVertex& own : screen) {
                // Its neighbors that are not clipped have the same, to the last bit of depth.
                CHECK((polygon.empty() || own.outside != 0 || has_own(polygon, own)));
            }
            longest = std::max(longest, polygon.size());
            for (const ScreenVertex& v : polygon) {
                CHECK(v.outside == 0);
                CHECK(std::abs(v.x) <= guard_px * 16);
                CHECK(std::abs(v.y) <= guard_px * 16);
                CHECK(v.z >= static_cast<int>(pxpl5::isa::region::z_margin));
                CHECK(v.z <=
                      static_cast<int>(pxpl5::isa::region::z_far - pxpl5::isa::region::z_margin));
            }
        }
        CHECK(longest >= 5);
    }

    TEST_CASE("the part before the eye is what perspective makes of it") {
        // A strip on the plane y = -1, from behind the eye to z = -100; near plane at 1.
        Camera c;
        c.width_px = c.height_px = 1024;
        c.projection = glm::perspective(2 * std::atan(1.0), 1.0, 1.0, 1000.0);
        const auto polygon =
            clipped({vertex(-1, -1, 50), vertex(1, -1, 50), vertex(0, -1, -100)}, c);
        REQUIRE(polygon.size() == 3);
        // At z = -1 the strip is 2 * 99 / 150 wide about 0 and y is -1: the picture's lower edge.
        const int half_width = static_cast<int>(std::lround(99.0 / 150 * 512 * 16));
        CHECK(has(polygon, 512 * 16 - half_width, 1024 * 16));
        CHECK(has(polygon, 512 * 16 + half_width, 1024 * 16));
        CHECK(has(polygon, 512 * 16, static_cast<int>(std::lround((512 + 5.12) * 16))));
    }

    TEST_CASE("nothing remains of what is wholly behind a plane") {
        Camera c = flat_camera();
        c.clip_planes = {{1, 0, 0, -200}};
        CHECK(clipped({vertex(50, 50, 0), vertex(150, 50, 0), vertex(150, 150, 0)}, c).empty());
    }
}
