// Spheres' programs, run by the reference and by the fast executor, against a ray through every
// pixel's center in exact mathematics.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "gp_firmware/render/draw_scene.hpp"
#include "gp_firmware/render/sphere_setup.hpp"
#include "isa/program.hpp"
#include "isa/reference/reference.hpp"
#include "renderer_firmware/fast/fast.hpp"
#include "tests/gp_firmware/render/support.hpp"

using namespace pxpl5;
using namespace pxpl5::test;
namespace region = isa::region;

namespace {

constexpr int size_px = 256;
/// Pixel centers nearer to an outline than this are not judged.
constexpr double outline_px = 0x1p-13;

void run(std::span<const std::uint32_t> words, isa::Executor& pixels) {
    for (std::size_t at = 0; at < words.size();) {
        const auto in = isa::decode(words[at]);
        REQUIRE(in);
        std::array<std::int32_t, 6> coefficients{};
        const std::size_t count = isa::instruction_words(words[at]) - 1;
        for (std::size_t k = 0; k < count; ++k) {
            coefficients[k] = static_cast<std::int32_t>(words[at + 1 + k]);
        }
        pixels.execute(*in, {coefficients.data(), count});
        at += 1 + count;
    }
}

/// Clears pixels like the prologue: no surface, all bits of z set.
void clear(isa::Executor& pixels) {
    const std::array<std::uint32_t, 3> words = {
        isa::encode({isa::Op::set_enabs, {}}),
        isa::encode({isa::Op::const_into_mem, {region::surface.address, 0, 32}}), 0xFFFF'FF00};
    run(words, pixels);
}

std::int64_t field(const isa::Executor& pixels, int x, int y, region::Field f, bool is_signed) {
    const auto bits = static_cast<std::int64_t>(pixels.field(x, y, f.address, f.width));
    const std::int64_t end = std::int64_t{1} << f.width;
    return is_signed && bits >= end / 2 ? bits - end : bits;
}

gp::Camera perspective_camera(Random& random) {
    gp::Camera camera;
    camera.width_px = camera.height_px = size_px;
    const double turn = random.real(0, 6.28);
    camera.voxel_to_eye =
        glm::translate(glm::dmat4(1.0), glm::dvec3(0, 0, -40)) *
        glm::rotate(glm::dmat4(1.0), turn, glm::normalize(glm::dvec3(1, random.real(-1, 1), 0.3)));
    camera.projection = glm::perspective(random.real(0.3, 1.0), 1.0, 20.0, 60.0);
    return camera;
}

gp::Camera orthographic_camera() {
    gp::Camera camera;
    camera.width_px = camera.height_px = size_px;
    camera.voxel_to_eye = glm::translate(glm::dmat4(1.0), glm::dvec3(0, 0, -40));
    camera.projection = glm::ortho(-12.0, 12.0, -12.0, 12.0, 20.0, 60.0);
    return camera;
}

/// The first hit of a ray through a pixel's center.
struct Hit {
    double clearance_px = 0;  ///< From the outline; inside is positive.
    double z = 0;             ///< Depth in units of the field.
    glm::dvec3 normal{0};     ///< Eye axes, unit.
    double w = 0;             ///< The divisor of the depth.
};

class Rays {
  public:
    explicit Rays(const gp::Camera& camera)
        : camera_(camera), to_eye_(glm::inverse(camera.projection)) {}

    Hit at(const gp::Sphere& sphere, int px, int py) const {
        const double x = 2 * (px + 0.5) / size_px - 1, y = 1 - 2 * (py + 0.5) / size_px;
        const glm::dvec3 origin = unprojected(x, y, -1), ahead = unprojected(x, y, 1);
        const glm::dvec3 d = glm::normalize(ahead - origin);
        const glm::dvec3 c = center(sphere);
        const double along = glm::dot(c - origin, d);
        const glm::dvec3 nearest = origin + d * along;
        const auto radius = static_cast<double>(sphere.radius);
        const double off = glm::distance(nearest, c);
        Hit hit;
        hit.clearance_px = (radius - off) * px_per_mm(nearest);
        const double depth2 = radius * radius - off * off;
        if (depth2 > 0) {
            const glm::dvec3 p = origin + d * (along - std::sqrt(depth2));
            const glm::dvec4 clip = camera_.projection * glm::dvec4(p, 1.0);
            hit.w = clip.w;
            hit.z = depth_units(clip.z / clip.w);
            hit.normal = (p - c) / radius;
        }
        return hit;
    }
    glm::dvec3 center(const gp::Sphere& sphere) const {
        return glm::dvec3(camera_.voxel_to_eye * glm::dvec4(glm::dvec3(sphere.p_voxel), 1.0));
    }
    /// Half of what the sphere reaches in depth, and the least w on it.
    std::pair<double, double> reach_and_w(const gp::Sphere& sphere) const {
        const glm::dvec3 c = center(sphere);
        const glm::dvec3 step(0, 0, static_cast<double>(sphere.radius));
        const auto project = [&](const glm::dvec3& p) {
            return camera_.projection * glm::dvec4(p, 1.0);
        };
        const glm::dvec4 front = project(c + step), back = project(c - step);
        return {(depth_units(back.z / back.w) - depth_units(front.z / front.w)) / 2, front.w};
    }

  private:
    static double depth_units(double ndc) {
        return (ndc * 0.5 + 0.5) * (region::z_far - 2.0 * region::z_margin) + region::z_margin;
    }
    glm::dvec3 unprojected(double x, double y, double z) const {
        const glm::dvec4 p = to_eye_ * glm::dvec4(x, y, z, 1.0);
        return glm::dvec3(p) / p.w;
    }
    double px_per_mm(const glm::dvec3& p) const {
        const glm::dvec4 clip = camera_.projection * glm::dvec4(p, 1.0);
        return camera_.projection[0][0] * size_px / 2 / clip.w;
    }

    const gp::Camera& camera_;
    glm::dmat4 to_eye_;
};

/// Draws each sphere as a surface of its own into one region.
void draw(const std::vector<gp::Sphere>& spheres, const gp::Camera& camera, int region_index,
          isa::Executor& pixels) {
    const gp::RegionGrid grid = gp::region_grid(size_px, size_px, 0);
    const gp::Projection projection = gp::prepare(camera);
    gp::RegionPrograms programs;
    programs.begin_frame(static_cast<std::size_t>(grid.count()));
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        const auto index = static_cast<std::uint16_t>(i);
        programs.begin_slab(index, 0);
        gp::SlabMesh mesh;
        mesh.spheres.push_back(spheres[i]);
        gp::draw_spheres(mesh, projection, grid, {index, false}, programs);
    }
    const auto words = words_of(programs, static_cast<std::size_t>(region_index), grid);
    REQUIRE(isa::check(words).ok());
    clear(pixels);
    run(words, pixels);
}

struct Outcome {
    int judged = 0, covered = 0, wrong = 0, skipped = 0;
};

/// Tolerance of depth: a unit of rounding each for the plane and the field, and a step of the
/// root.
double depth_tolerance(double reach) {
    return 2 + reach * 1.5 * 0x1p-16;
}

/// Compares a window of a region, pixel by pixel, with what rays meet.
Outcome judge(const std::vector<gp::Sphere>& spheres, const gp::Camera& camera, int region_index,
              isa::reference::Window window, const isa::Executor& pixels) {
    const Rays rays(camera);
    const int x0 = region_index % 2 * 128, y0 = region_index / 2 * 128;
    Outcome outcome;
    for (int y = window.y0; y < window.y0 + window.height; ++y) {
        for (int x = window.x0; x < window.x0 + window.width; ++x) {
            std::optional<std::size_t> first;
            Hit best;
            double slack = 0;
            bool doubtful = false;
            for (std::size_t i = 0; i < spheres.size(); ++i) {
                const Hit hit = rays.at(spheres[i], x0 + x, y0 + y);
                doubtful = doubtful || std::abs(hit.clearance_px) < outline_px;
                if (hit.clearance_px <= 0) {
                    continue;
                }
                const double tolerance = depth_tolerance(rays.reach_and_w(spheres[i]).first);
                if (first && std::abs(hit.z - best.z) < tolerance + slack) {
                    doubtful = true;  // So near to each other that either may win.
                }
                if (!first || hit.z < best.z) {
                    first = i;
                    best = hit;
                    slack = tolerance;
                }
            }
            if (doubtful) {
                ++outcome.skipped;
                continue;
            }
            ++outcome.judged;
            const auto surface = field(pixels, x, y, region::surface, false);
            bool good = surface == (first ? static_cast<std::int64_t>(*first) + 1 : 0);
            const auto z = static_cast<double>(field(pixels, x, y, region::z, false));
            if (first && good) {
                ++outcome.covered;
                const double w_min = rays.reach_and_w(spheres[*first]).second;
                const glm::dvec3 normal = best.normal * (region::normal_unit * w_min / best.w);
                const glm::dvec3 stored(
                    static_cast<double>(field(pixels, x, y, region::normal_x, true)),
                    static_cast<double>(field(pixels, x, y, region::normal_y, true)),
                    static_cast<double>(field(pixels, x, y, region::normal_z, true)));
                good = std::abs(z - best.z) <= slack && glm::length(glm::abs(stored - normal)) < 2;
            } else if (good) {
                good = z == region::z_far;
            }
            outcome.wrong += good ? 0 : 1;
        }
    }
    return outcome;
}

/// On both executors: the fast one over the whole region, the reference in a window.
void check(const std::vector<gp::Sphere>& spheres, const gp::Camera& camera,
           isa::reference::Window window, int least_covered) {
    CAPTURE(seed());
    int covered = 0;
    renderer::fast::Fast fast;
    for (int region_index = 0; region_index < 4; ++region_index) {
        CAPTURE(region_index);
        draw(spheres, camera, region_index, fast);
        const Outcome all = judge(spheres, camera, region_index, {0, 0, 128, 128}, fast);
        CHECK(all.wrong == 0);
        CHECK(all.skipped < 128 * 128 / 50);
        covered += all.covered;
        fast.reset();
    }
    CHECK(covered >= least_covered);
    isa::reference::Reference reference(window);
    draw(spheres, camera, 0, reference);
    const Outcome part = judge(spheres, camera, 0, window, reference);
    CHECK(part.wrong == 0);
    CHECK(part.judged > 0);
}

gp::Sphere sphere_at(double x, double y, double z, double radius) {
    return {{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)},
            static_cast<float>(radius)};
}

}  // namespace

TEST_SUITE("gp/spheres") {
    TEST_CASE("one sphere in the middle, in perspective and without") {
        Random random(11);
        for (int round = 0; round < 3; ++round) {
            check({sphere_at(0, 0, 0, 6)}, perspective_camera(random), {100, 100, 24, 24}, 5000);
        }
        check({sphere_at(1, 2, 3, 8)}, orthographic_camera(), {100, 90, 24, 24}, 20000);
    }
    TEST_CASE("spheres of a few pixels and of less than one") {
        Random random(12);
        std::vector<gp::Sphere> spheres;
        for (int i = 0; i < 60; ++i) {
            spheres.push_back(sphere_at(random.real(-7, 7), random.real(-7, 7), random.real(-7, 7),
                                        random.real(0.02, 0.5)));
        }
        check(spheres, perspective_camera(random), {96, 96, 32, 32}, 500);
    }
    TEST_CASE("spheres that cut each other, as a molecule's do") {
        Random random(13);
        std::vector<gp::Sphere> spheres;
        for (int i = 0; i < 12; ++i) {
            spheres.push_back(sphere_at(random.real(-4, 4), random.real(-4, 4), random.real(-4, 4),
                                        random.real(1.5, 3)));
        }
        check(spheres, perspective_camera(random), {96, 96, 32, 32}, 4000);
    }
    TEST_CASE("a sphere that fills the picture, and one whose middle is outside of it") {
        Random random(14);
        gp::Camera camera = perspective_camera(random);
        camera.projection = glm::perspective(0.12, 1.0, 20.0, 60.0);
        check({sphere_at(0, 0, 0, 10)}, camera, {60, 60, 16, 16}, 65000);
        camera.voxel_to_eye = glm::translate(glm::dmat4(1.0), glm::dvec3(-9, 4, -40));
        check({sphere_at(0, 0, 0, 9)}, camera, {60, 60, 16, 16}, 1000);
    }
    TEST_CASE("the box holds all pixels of a sphere, and hardly more") {
        Random random(15);
        CAPTURE(seed());
        gp::Camera camera = perspective_camera(random);
        camera.projection = glm::perspective(1.4, 1.0, 20.0, 60.0);  // Wide: spheres look long.
        const gp::RegionGrid grid = gp::region_grid(size_px, size_px, 0);
        const Rays rays(camera);
        int seen = 0;
        for (int round = 0; round < 40; ++round) {
            const gp::Sphere sphere = sphere_at(random.real(-12, 12), random.real(-12, 12),
                                                random.real(-12, 12), random.real(1, 6));
            gp::PixelBox exact{size_px, size_px, -1, -1};
            for (int i = 0; i < size_px * size_px; ++i) {
                const int x = i % size_px, y = i / size_px;
                if (rays.at(sphere, x, y).clearance_px > 0) {
                    exact = {std::min(exact.x0, x), std::min(exact.y0, y), std::max(exact.x1, x),
                             std::max(exact.y1, y)};
                }
            }
            const auto screen = gp::screen_sphere(sphere, gp::prepare(camera), grid);
            if (!screen || exact.empty()) {
                continue;
            }
            ++seen;
            // A sliver may reach into the box's last row without holding a center of it.
            const auto wider = [](int by) { return by == 0 || by == 1; };
            CHECK(wider(exact.x0 - screen->box.x0));
            CHECK(wider(exact.y0 - screen->box.y0));
            CHECK(wider(screen->box.x1 - exact.x1));
            CHECK(wider(screen->box.y1 - exact.y1));
        }
        CHECK(seen > 20);
    }
    TEST_CASE("what cannot be drawn whole is left out") {
        const gp::RegionGrid grid = gp::region_grid(size_px, size_px, 0);
        gp::Camera camera = orthographic_camera();
        const auto drawn = [&](const gp::Sphere& sphere) {
            return gp::screen_sphere(sphere, gp::prepare(camera), grid).has_value();
        };
        CHECK(drawn(sphere_at(0, 0, 0, 1)));
        CHECK(!drawn(sphere_at(0, 0, 19.5, 1)));   // Through the near plane.
        CHECK(!drawn(sphere_at(0, 0, -19.5, 1)));  // Through the far plane.
        CHECK(!drawn(sphere_at(14, 0, 0, 1)));     // Beside the picture.
        CHECK(drawn(sphere_at(12.5, 0, 0, 1)));    // Across its border.
        CHECK(!drawn(sphere_at(0, 0, 0, 1e-4)));   // Not a hundredth of a pixel.
        camera.clip_planes.emplace_back(1, 0, 0, 0);
        CHECK(!drawn(sphere_at(0, 0, 0, 1)));  // Cut by a plane.
        CHECK(drawn(sphere_at(1.5, 0, 0, 1)));
        camera.clip_planes.clear();
        camera.projection = glm::perspective(0.5, 1.0, 0.01, 60.0);
        CHECK(!drawn(sphere_at(0, 0, 39.5, 1)));  // Around the eye.
    }
    TEST_CASE("a sphere and a polygon cut each other where they do in space") {
        const gp::Camera camera = orthographic_camera();
        const gp::Projection projection = gp::prepare(camera);
        const gp::RegionGrid grid = gp::region_grid(size_px, size_px, 0);
        const gp::Sphere sphere = sphere_at(0, 0, 0, 8);
        gp::SlabMesh mesh;  // The plane z = x / 2, larger than the picture.
        for (const auto& [x, y] : {std::pair{-30, -60}, {30, -60}, {0, 120}}) {
            mesh.vertices.push_back(
                {{static_cast<float>(x), static_cast<float>(y), static_cast<float>(x) / 2},
                 {0, 0, 32767}});
        }
        mesh.indices = {0, 1, 2};
        gp::RegionPrograms programs;
        programs.begin_frame(4);
        gp::DrawScratch scratch;
        programs.begin_slab(0, 0);
        gp::draw_slab(mesh, projection, grid, {0, false}, scratch, programs);
        mesh = {};
        mesh.spheres.push_back(sphere);
        programs.begin_slab(1, 0);
        gp::draw_spheres(mesh, projection, grid, {1, false}, programs);
        int wrong = 0, skipped = 0;
        renderer::fast::Fast pixels;
        for (int r = 0; r < 4; ++r) {
            pixels.reset();
            clear(pixels);
            run(words_of(programs, static_cast<std::size_t>(r), grid), pixels);
            for (int y = 0; y < 128; ++y) {
                for (int x = 0; x < 128; ++x) {
                    const double px = (r % 2 * 128 + x + 0.5) * 24 / size_px - 12;
                    const double py = 12 - (r / 2 * 128 + y + 0.5) * 24 / size_px;
                    const double rest = 64 - px * px - py * py;
                    const double ahead = rest > 0 ? std::sqrt(rest) - px / 2 : -1;
                    if (std::abs(rest) < 1e-3 || (rest > 0 && std::abs(ahead) < 1e-3)) {
                        ++skipped;
                        continue;
                    }
                    const bool is_sphere = field(pixels, x, y, region::surface, false) == 2;
                    wrong += is_sphere == (ahead > 0) ? 0 : 1;
                }
            }
        }
        CHECK(wrong == 0);
        CHECK(skipped < 50);
    }
}
