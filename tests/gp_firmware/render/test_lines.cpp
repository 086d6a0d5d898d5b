#include <doctest/doctest.h>

#include <cmath>

#include "gp_firmware/render/draw_scene.hpp"
#include "tests/gp_firmware/render/support.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

constexpr double half_width_px = gp::line_width_subpixels / 32.0;

/// A line of pixel_camera()'s voxels, which are pixels; in the middle of the depth range.
gp::Line line(double ax, double ay, double bx, double by) {
    const auto point = [](double x, double y) {
        return glm::vec3(static_cast<float>(x), static_cast<float>(y), 0.5F);
    };
    return {point(ax, ay), point(bx, by)};
}

std::vector<int> drawn(const gp::Line& l, gp::Camera camera = pixel_camera(256, 256)) {
    const gp::RegionGrid grid = gp::region_grid(256, 256, 0);
    gp::RegionPrograms programs;
    programs.begin_frame(4);
    programs.begin_slab(0, 0);
    gp::SlabMesh mesh;
    mesh.lines.push_back(l);
    gp::draw_lines(mesh, gp::prepare(camera), grid, {0, false}, programs);
    return coverage(programs, grid);
}

/// Pixels whose centers lie in the box around the line are covered once, others not at all; those
/// within a subpixel of the box's border may be either.
void check_box(const gp::Line& l) {
    const std::vector<int> counts = drawn(l);
    const double dx = double{l.to_voxel.x} - double{l.from_voxel.x},
                 dy = double{l.to_voxel.y} - double{l.from_voxel.y}, length = std::hypot(dx, dy);
    int wrong = 0, covered = 0;
    for (int y = 0; y < 256; ++y) {
        for (int x = 0; x < 256; ++x) {
            const double px = x + 0.5 - double{l.from_voxel.x},
                         py = y + 0.5 - double{l.from_voxel.y};
            const double along = (px * dx + py * dy) / length,
                         off = std::abs(px * dy - py * dx) / length;
            const double out = std::max(
                {-half_width_px - along, along - length - half_width_px, off - half_width_px});
            const int count = counts[static_cast<std::size_t>(y * 256 + x)];
            covered += count;
            if (std::abs(out) > 1.0 / 16) {
                wrong += count == (out < 0 ? 1 : 0) ? 0 : 1;
            } else {
                wrong += count <= 1 ? 0 : 1;
            }
        }
    }
    CHECK(wrong == 0);
    CHECK(covered > 0);
}

}  // namespace

TEST_SUITE("gp/lines") {
    TEST_CASE("a line is a box of constant width, covered once, in any direction and region") {
        check_box(line(10, 20, 50, 20));
        check_box(line(20, 10, 20, 200));
        check_box(line(30, 30, 220, 140));
        check_box(line(220, 30, 30, 190));
        check_box(line(100.3, 100.7, 103.1, 98.2));
    }
    TEST_CASE("a line towards the eye is a dot") {
        const gp::Line l{{64, 64, 0.2F}, {64, 64, 0.8F}};
        int covered = 0;
        for (const int count : drawn(l)) {
            covered += count;
        }
        CHECK(covered >= 1);
        CHECK(covered <= 4);
    }
    TEST_CASE("a line is cut at the near plane, the far plane, a clip plane and the guard band") {
        const auto columns = [](const gp::Line& l, const gp::Camera& camera) {
            std::pair<int, int> range{256, -1};
            const std::vector<int> counts = drawn(l, camera);
            for (int i = 0; i < 256 * 256; ++i) {
                if (counts[static_cast<std::size_t>(i)] > 0) {
                    range = {std::min(range.first, i % 256), std::max(range.second, i % 256)};
                }
            }
            return range;
        };
        gp::Camera camera = pixel_camera(256, 256);
        // From in front of the depth range to behind it: half of it is seen.
        const auto [first, last] = columns({{50, 50, -0.5F}, {150, 50, 1.5F}}, camera);
        CHECK(std::abs(first - 75) <= 1);
        CHECK(std::abs(last - 124) <= 1);
        CHECK(columns(line(-1e5, 80, 1e5, 80), camera) == std::pair(0, 255));
        CHECK(columns(line(-50, 80, -20, 80), camera).second == -1);
        camera.clip_planes.emplace_back(1, 0, 0, -100);  // x >= 100.
        CHECK(std::abs(columns(line(20, 80, 140, 80), camera).first - 99) <= 1);
    }
}
