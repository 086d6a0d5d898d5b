// Depths read back from a whole machine: picked points, clipped surfaces, transparent surfaces.
#include <fmt/format.h>

#include "host/base/error.hpp"
#include "host/inspect/listing/run_stats.hpp"
#include "host/inspect/record/recorded_results.hpp"
#include "host/inspect/replay/replay.hpp"
#include "host/inspect/step/step_view.hpp"
#include "host/phantom/phantom.hpp"
#include "host/scene/pick.hpp"
#include "isa/contract/depth.hpp"
#include "tests/host/inspect/ray_check.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

constexpr int width = 300, height = 200;
const glm::dvec3 sphere_center_mm(0.3, -0.7, 0.45);  // As of the phantom.
constexpr double sphere_radius_mm = 30, sphere_surface = 0.5;
constexpr double inner_radius_mm = 20, inner_surface = 1000.5;  // 0.01 mm a step.

/// The last frame's depths; keeps the message that holds them.
struct Depths {
    inspect::RecordedFrame frame;
    std::span<const std::uint32_t> words;

    explicit Depths(const inspect::RecordedRun& run) : frame(run.frame(run.frames().back())) {
        const auto* done = frame.done.at(0).as<bus::schema::FrameDone>();
        REQUIRE(done->depths() != nullptr);
        words = {done->depths()->data(), done->depths()->size()};
    }
    std::uint32_t at(int x, int y) const { return words[static_cast<std::size_t>(y * width + x)]; }
};

host::PickView view_of(const RecordedSurface& recorded, const host::Camera& camera,
                       const Depths& depths) {
    const host::Volume& v = recorded.volume();
    return {host::camera_matrices(camera, host::subject_of(v.nx, v.ny, v.nz, v.voxel_to_patient),
                                  static_cast<double>(width) / height),
            width, height, depths.words};
}

void wants_depths(bus::schema::DrawFrameT& draw) {
    draw.read_back = true;
    draw.read_depths = true;
}

/// Planes tangential to an ellipsoid around the grid's middle: they cut a gem out of it.
std::vector<glm::dvec4> gem(const host::Volume& v, std::size_t count, double share) {
    std::vector<glm::dvec4> planes;
    std::mt19937 random(test_seed(11));
    std::normal_distribution<double> number;
    const glm::dvec3 half = (glm::dvec3(v.nx, v.ny, v.nz) - 1.0) / 2.0;
    while (planes.size() < count) {
        const glm::dvec3 n =
            glm::normalize(glm::dvec3(number(random), number(random), number(random)));
        planes.emplace_back(-n, glm::dot(n, half) + share * glm::length(n * half));
    }
    return planes;
}

/// 1 if all of the triangle is kept, -1 if none of it is, 0 if a plane cuts it.
int kept(const TrueTriangle& t, const std::vector<glm::dvec4>& planes) {
    int verdict = 1;
    for (const glm::dvec4& plane : planes) {
        int in = 0;
        for (const glm::dvec3& p : t.p_voxel) {
            in += glm::dot(plane, glm::dvec4(p, 1)) >= 0 ? 1 : 0;
        }
        if (in == 0) {
            return -1;
        }
        verdict = in == 3 ? verdict : 0;
    }
    return verdict;
}

struct Seen {
    int surface = 0, background = 0, opened = 0;
};

/// Holds random pixels of a clipped surface against the triangles that planes leave on their rays.
Seen check_clipped(const RecordedSurface& recorded, double isovalue,
                   const std::vector<glm::dvec4>& planes) {
    const auto truth = true_triangles(recorded.volume(), isovalue, recorded.view());
    const inspect::RecordedRun run = recorded.run();
    const Depths depths(run);
    std::mt19937 random(test_seed(12));
    std::uniform_int_distribution<int> column(0, width - 1), row(0, height - 1);
    Seen seen;
    for (int n = 0; n < 3000; ++n) {
        const int x = column(random), y = row(random);
        const OnRay all = on_ray(truth, x, y);
        OnRay left;
        const auto keep = [&](const auto& from, auto& to) {
            std::ranges::copy_if(from, std::back_inserter(to),
                                 [&](const TrueTriangle* t) { return kept(*t, planes) == 1; });
        };
        keep(all.sure, left.sure);
        keep(all.possible, left.possible);
        const bool is_cut = std::ranges::any_of(
            all.possible, [&](const TrueTriangle* t) { return kept(*t, planes) == 0; });
        if (is_cut || left.sure.empty() != left.possible.empty()) {
            continue;  // Near a cut or an edge either may be right.
        }
        INFO("pixel ", x, ", ", y);
        const std::uint32_t word = depths.at(x, y);
        CHECK((word & 0xFF) == (left.sure.empty() ? 0 : 1));
        if (left.sure.empty()) {
            ++seen.background;
            seen.opened += all.sure.empty() ? 0 : 1;
            continue;
        }
        ++seen.surface;
        const glm::dvec2 p = center_of(x, y);
        const double depth = (isa::ndc_of_depth(word >> 8) + 1) / 2;
        CHECK(std::ranges::any_of(left.possible, [&](const TrueTriangle* t) {
            return may_be_nearest(left, t->name, p) &&
                   std::abs(t->depth_at(p) - depth) <= depth_doubt(*t);
        }));
        const auto nearer = [&](const TrueTriangle* t) { return t->depth_at(p) + 0.001 < depth; };
        seen.opened += std::ranges::any_of(all.sure, nearer) ? 1 : 0;
    }
    return seen;
}

void use(bus::schema::DrawFrameT& draw, const std::vector<glm::dvec4>& planes) {
    wants_depths(draw);
    for (const glm::dvec4& p : planes) {
        draw.clip_planes.emplace_back(static_cast<float>(p.x), static_cast<float>(p.y),
                                      static_cast<float>(p.z), static_cast<float>(p.w));
    }
}

}  // namespace

TEST_SUITE("pick") {
    TEST_CASE("a picked point lies on the sphere, in the cell that why names") {
        const host::Camera camera{{30, 25}, 1.0};
        RecordedSurface recorded(host::make_phantom("phantom:sphere"), 3, 2);
        recorded.add_surface(sphere_surface);
        recorded.draw(camera, width, height, wants_depths);
        const inspect::RecordedRun run = recorded.run();
        const Depths depths(run);
        const host::PickView view = view_of(recorded, camera, depths);
        inspect::FrameInquiry frame(run, std::nullopt);
        std::mt19937 random(test_seed(3));
        std::uniform_int_distribution<int> column(0, width - 1), row(0, height - 1);
        int hits = 0, misses = 0;
        for (int n = 0; n < 1500; ++n) {
            const int x = column(random), y = row(random);
            INFO("pixel ", x, ", ", y);
            const auto found = host::pick(view, x, y, recorded.volume());
            if (!found) {
                ++misses;
                continue;
            }
            ++hits;
            constexpr double voxel_mm = 1.25;  // The least of the three.
            CHECK(std::abs(glm::distance(found->p_mm, sphere_center_mm) - sphere_radius_mm) <
                  0.1 * voxel_mm);
            CHECK(found->surface == 0);
            CHECK(found->is_in_volume);
            CHECK(found->doubt_mm < 0.001);
            // Density is depth below the surface, so it is about 0 there.
            CHECK(std::abs(found->value_between.value()) < 0.1 * voxel_mm * 100);
            CHECK(found->value == voxel(recorded.volume(), found->x, found->y, found->z));
            CHECK(glm::distance(found->p_voxel, glm::dvec3(found->x, found->y, found->z)) <
                  std::sqrt(0.75) + 1e-9);
            if (hits % 8 == 0) {
                const inspect::WhyFinding why = inspect::why(frame, x, y);
                const TriangleName& cell = why.shown()->cell.value().name;
                const glm::dvec3 low(cell.i, cell.j, cell.k);
                CHECK(glm::all(glm::greaterThan(found->p_voxel, low - 0.1)));
                CHECK(glm::all(glm::lessThan(found->p_voxel, low + 1.1)));
                CHECK(glm::distance(found->p_grid, why.shown()->cell->hit_voxel) < 0.1);
            }
        }
        CHECK(hits > 200);
        CHECK(misses > 100);
        CHECK_THROWS_WITH(host::pick(view, width, 3, recorded.volume()),
                          "pixel (300, 3) is outside of the picture, which has 300 x 200 pixels, "
                          "counted from 0");
        CHECK_THROWS_AS(host::pick(view, 0, -1, recorded.volume()), host::RequestError);
    }
    TEST_CASE("a recorded region has the depths that its Renderer sent, or shows the background") {
        RecordedSurface recorded(host::make_phantom("phantom:sphere"), 2, 2);
        recorded.add_surface(sphere_surface);
        recorded.draw({{30, 25}, 0.5}, width, height, wants_depths);
        const inspect::RecordedRun run = recorded.run();
        const Depths depths(run);
        std::vector<int> counts(2);  // Regions without and with depths.
        constexpr int across = 3, regions = 6, px = 128;
        for (int region = 0; region < regions; ++region) {
            const auto tile = inspect::tile_of(depths.frame, static_cast<std::uint32_t>(region));
            REQUIRE(tile);
            ++counts[tile->depths.empty() ? 0 : 1];
            int wrong = 0;
            for (int y = 0; y < px && region / across * px + y < height; ++y) {
                for (int x = 0; x < px && region % across * px + x < width; ++x) {
                    const auto at = static_cast<std::size_t>(y * px + x);
                    const std::uint32_t word =
                        tile->depths.empty() ? 0xFFFF'FF00 : tile->depths[at];
                    wrong += depths.at(region % across * px + x, region / across * px + y) == word
                                 ? 0
                                 : 1;
                }
            }
            CHECK(wrong == 0);
        }
        CHECK(counts[0] >= 2);
        CHECK(counts[1] >= 2);
    }
    TEST_CASE("where slices are unevenly spaced, the point's slice is counted by their places") {
        host::Volume volume = host::make_phantom("phantom:sphere");
        const host::Volume even = volume;
        for (int z = 0; z < volume.nz; ++z) {
            volume.slice_places.push_back(z < 20 ? z : 20 + (z - 20) * 1.5);
        }
        const host::Camera camera{{30, 25}, 1.0};
        RecordedSurface recorded(volume, 2, 1);
        recorded.add_surface(sphere_surface);
        recorded.draw(camera, width, height, wants_depths);
        const inspect::RecordedRun run = recorded.run();
        const Depths depths(run);
        const host::PickView view = view_of(recorded, camera, depths);
        int beyond = 0;
        for (int y = 10; y < height; y += 7) {
            for (int x = 5; x < width; x += 7) {
                if (const auto found = host::pick(view, x, y, recorded.volume())) {
                    // The slices as they were before they were moved give the sphere.
                    const glm::dvec3 p(even.voxel_to_patient * glm::dvec4(found->p_voxel, 1));
                    CHECK(std::abs(glm::distance(p, sphere_center_mm) - sphere_radius_mm) < 0.125);
                    beyond += found->p_voxel.z > 21 ? 1 : 0;
                }
            }
        }
        CHECK(beyond > 50);
    }
}

TEST_SUITE("clip planes") {
    TEST_CASE("half a sphere shows its inside, lit from both sides, or what is behind") {
        const host::Camera camera{{0, 0}, 1.0};  // From the front: -y.
        RecordedSurface recorded(host::make_phantom("phantom:sphere"), 2, 2);
        recorded.add_surface(sphere_surface);
        // Patient's y against -0.7, the sphere's middle: the front half goes.
        const glm::dvec4 in_patient(0, 1, 0, -sphere_center_mm.y);
        const std::vector<glm::dvec4> planes = {glm::transpose(recorded.volume().voxel_to_patient) *
                                                in_patient};
        recorded.draw(camera, width, height, [&](bus::schema::DrawFrameT& draw) {
            use(draw, planes);
            draw.ambient = 0.25F;
            draw.lights.emplace_back(bus::schema::Vec3(0, 0, 1), 0.75F);
        });
        const Seen seen = check_clipped(recorded, sphere_surface, planes);
        CHECK(seen.surface > 200);
        CHECK(seen.opened > 150);  // All of it is the inside of the back.
        const inspect::RecordedRun run = recorded.run();
        const Depths depths(run);
        const host::PickView view = view_of(recorded, camera, depths);
        const auto* pixels = depths.frame.done.at(0).as<bus::schema::FrameDone>()->pixels();
        int lit = 0;
        for (int y = 0; y < height; y += 3) {
            for (int x = 0; x < width; x += 3) {
                const auto found = host::pick(view, x, y, recorded.volume());
                if (!found) {
                    continue;
                }
                CHECK(found->p_mm.y > sphere_center_mm.y - 0.2);
                // Red is 200; the inside's normal, turned to the viewer, meets the light.
                const double n = (found->p_mm.y - sphere_center_mm.y) / sphere_radius_mm;
                const auto red = pixels->Get(static_cast<unsigned>(y * width + x)) & 0xFF;
                CHECK(std::abs(red - 200 * (0.25 + 0.75 * n)) < 8);
                ++lit;
            }
        }
        CHECK(lit > 300);
    }
    TEST_CASE("one to sixteen planes leave of a torus what is on the kept side of all") {
        RecordedSurface recorded(host::make_phantom("phantom:torus"), 3, 2);
        recorded.add_surface(30000.5);
        for (const std::size_t count : {1U, 5U, 16U}) {
            CAPTURE(count);
            const auto planes = gem(recorded.volume(), count, count == 1 ? 0.1 : 0.62);
            recorded.draw({{30, 25}, 1.0}, width, height,
                          [&](bus::schema::DrawFrameT& draw) { use(draw, planes); });
            const Seen seen = check_clipped(recorded, 30000.5, planes);
            MESSAGE(count, " planes: ", seen.surface, " pixels, ", seen.opened, " opened");
            CHECK(seen.surface > 100);
            CHECK(seen.background > 100);
            CHECK(seen.opened > 50);
        }
    }
}
