// A whole surface through transform, culling, binning and emission.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tests/gp_firmware/render/support.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

constexpr int slabs = 12;
constexpr int around = 48;

/// A sphere of `radius` voxels about the origin, in slabs of latitude, wound counter-clockwise seen
/// from outside.
std::vector<gp::SlabMesh> sphere(double radius) {
    constexpr double pi = 3.14159265358979;
    const auto point = [&](int latitude, int longitude) {
        const double theta = pi * latitude / slabs, phi = 2 * pi * (longitude % around) / around;
        const glm::dvec3 n(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                           std::cos(theta));
        const auto unit = [](double c) {
            return static_cast<std::int16_t>(std::lround(c * 32767));
        };
        return gp::Vertex{glm::vec3(n * radius), {unit(n.x), unit(n.y), unit(n.z)}, 0};
    };
    std::vector<gp::SlabMesh> meshes(slabs);
    for (int slab = 0; slab < slabs; ++slab) {
        gp::SlabMesh& mesh = meshes[static_cast<std::size_t>(slab)];
        mesh.slab = slab;
        for (int i = 0; i < around; ++i) {
            for (const int k : {0, 1}) {
                mesh.vertices.push_back(point(slab + k, i));
            }
        }
        for (std::uint32_t i = 0; i < around; ++i) {
            const std::uint32_t a = 2 * i, b = a + 1, c = 2 * ((i + 1) % around), d = c + 1;
            for (const std::uint32_t index : {a, b, d, a, d, c}) {
                mesh.indices.push_back(index);
            }
        }
    }
    return meshes;
}

/// Looks at the origin from +z at `distance`, `half_angle_tan` to the picture's edge.
gp::Camera looking_down(int size_px, double distance, double half_angle_tan) {
    gp::Camera camera;
    camera.width_px = camera.height_px = size_px;
    camera.voxel_to_eye[3] = glm::dvec4(0, 0, -distance, 1);
    const double near = 1, far = 2 * distance;
    camera.projection = glm::dmat4(0.0);
    camera.projection[0][0] = camera.projection[1][1] = 1 / half_angle_tan;
    camera.projection[2][2] = -(far + near) / (far - near);
    camera.projection[2][3] = -1;
    camera.projection[3][2] = -2 * far * near / (far - near);
    return camera;
}

struct Drawing {
    gp::RegionGrid grid;
    gp::RegionPrograms programs;
    gp::DrawCounts counts;
};

/// Draws the slabs s with s mod `gp_count` == `index`.
Drawing draw(const std::vector<gp::SlabMesh>& meshes, const gp::Camera& camera, bool cull_back,
             int gp_count = 1, int index = 0) {
    Drawing d;
    d.grid = gp::region_grid(camera.width_px, camera.height_px, 0);
    d.programs.begin_frame(static_cast<std::size_t>(d.grid.count()));
    gp::DrawScratch scratch;
    const gp::Projection projection = gp::prepare(camera);
    for (const gp::SlabMesh& mesh : meshes) {
        if (mesh.slab % gp_count == index) {
            d.programs.begin_slab(0, static_cast<std::uint32_t>(mesh.slab));
            const gp::DrawCounts c =
                gp::draw_slab(mesh, projection, d.grid, {0, cull_back}, scratch, d.programs);
            d.counts.triangles_in += c.triangles_in;
            d.counts.triangles_out += c.triangles_out;
        }
    }
    d.programs.end_frame();
    return d;
}

/// Words of each region, by slab.
std::map<std::pair<std::size_t, std::uint32_t>, std::vector<std::uint32_t>> by_slab(
    const std::vector<Drawing>& drawings) {
    std::map<std::pair<std::size_t, std::uint32_t>, std::vector<std::uint32_t>> result;
    for (const Drawing& d : drawings) {
        for (std::size_t region = 0; region < d.programs.regions().size(); ++region) {
            const gp::RegionProgram& program = d.programs.regions()[region];
            const auto words = words_of(d.programs, region, d.grid);
            for (const gp::Segment& s : program.segments) {
                const auto part = std::span(words).subspan(s.first_word, s.word_count);
                auto& all = result[{region, s.slab}];
                all.insert(all.end(), part.begin(), part.end());
            }
        }
    }
    return result;
}

/// How many pixels are covered how often, split by their distance from the picture's middle.
struct Rings {
    std::map<int, int> inside, outside;
};

Rings rings(const Drawing& d, double r_inside, double r_outside) {
    const std::vector<int> counts = coverage(d.programs, d.grid);
    Rings result;
    for (int y = 0; y < d.grid.height_px; ++y) {
        for (int x = 0; x < d.grid.width_px; ++x) {
            const double r =
                std::hypot(x + 0.5 - d.grid.width_px / 2.0, y + 0.5 - d.grid.height_px / 2.0);
            const int count = counts[static_cast<std::size_t>(y * d.grid.width_px + x)];
            if (r < r_inside) {
                ++result.inside[count];
            } else if (r > r_outside) {
                ++result.outside[count];
            }
        }
    }
    return result;
}

}  // namespace

TEST_SUITE("gp/draw slab") {
    // Distance 100, radius 20, edge of the picture at 25: the silhouette has radius
    // 20 / sqrt(1 - 0.2^2) / 25 of half the picture. 48 chords stay within 1 - cos(pi / 48) of it.
    const double silhouette_px = 150 * 20 / std::sqrt(1 - 0.04) / 25;

    TEST_CASE("a closed surface is covered once by its front and once by its back") {
        const auto camera = looking_down(300, 100, 0.25);
        const Rings both =
            rings(draw(sphere(20), camera, false), silhouette_px * 0.96, silhouette_px + 1);
        CHECK(both.inside.size() == 1);
        CHECK(both.inside.count(2) == 1);
        CHECK(both.outside.size() == 1);
        CHECK(both.outside.count(0) == 1);
        const Rings front =
            rings(draw(sphere(20), camera, true), silhouette_px * 0.96, silhouette_px + 1);
        CHECK(front.inside.size() == 1);
        CHECK(front.inside.count(1) == 1);
    }

    TEST_CASE("culling of backs keeps what faces the eye") {
        // All normals that remain point towards the eye, but for the silhouette's triangles.
        const Drawing d = draw(sphere(20), looking_down(300, 100, 0.25), true);
        const double share = static_cast<double>(d.counts.triangles_out) / d.counts.triangles_in;
        CHECK(share > 0.3);
        for (const gp::RegionProgram& region : d.programs.regions()) {
            for (const gp::Segment& s : region.segments) {
                // Slabs count from the pole that faces the eye; the far half is gone.
                CHECK(s.slab < slabs / 2 + 1);
            }
        }
    }

    TEST_CASE("every count adds up") {
        const Drawing d = draw(sphere(20), looking_down(300, 100, 0.25), false);
        CHECK(d.counts.triangles_in == slabs * around * 2);
        std::size_t words = 0;
        for (const gp::RegionProgram& region : d.programs.regions()) {
            words += region.word_count();
            std::size_t in_segments = 0;
            for (const gp::Segment& s : region.segments) {
                CHECK(s.first_word == in_segments);
                in_segments += s.word_count;
            }
            CHECK(in_segments == region.word_count());
        }
        CHECK(words == d.counts.triangles_out * shape::word_count);
    }

    TEST_CASE("streams are the same words however slabs are split over GPs") {
        const auto meshes = sphere(20);
        // Near enough that some triangles are clipped.
        for (const auto& camera : {looking_down(300, 100, 0.25), looking_down(500, 20.5, 1)}) {
            std::vector<Drawing> alone;
            alone.push_back(draw(meshes, camera, false));
            const auto expected = by_slab(alone);
            CHECK(expected.size() > 12);
            for (const int gp_count : {2, 3, 7, 36}) {
                std::vector<Drawing> split;
                for (int index = 0; index < gp_count; ++index) {
                    split.push_back(draw(meshes, camera, false, gp_count, index));
                }
                CHECK(by_slab(split) == expected);
            }
        }
    }

    TEST_CASE("from within a closed surface every pixel is covered exactly once") {
        // The eye is in the sphere: triangles cross its plane, the near plane and the guard band.
        for (const double half_angle_tan : {0.001, 0.05, 1.0, 8.0}) {
            gp::Camera deep = looking_down(256, 16, half_angle_tan);
            // No far plane.
            deep.projection[2][2] = -1.001;
            deep.projection[3][2] = -2.001;
            const std::vector<int> counts =
                coverage(draw(sphere(20), deep, false).programs, gp::region_grid(256, 256, 0));
            INFO("tan ", half_angle_tan);
            CHECK(std::ranges::count(counts, 1) == std::ssize(counts));
        }
    }

    TEST_CASE("a clip plane opens the surface") {
        gp::Camera camera = looking_down(300, 100, 0.25);
        camera.clip_planes.push_back({0, 0, -1, 0});  // Keeps z <= 0: the far half.
        const Drawing d = draw(sphere(20), camera, false);
        const Rings half = rings(d, 150 * 20 / 25.0 * 0.95, silhouette_px + 1);
        CHECK(half.inside.size() == 1);
        CHECK(half.inside.count(1) == 1);
        for (const gp::RegionProgram& region : d.programs.regions()) {
            for (const gp::Segment& s : region.segments) {
                CHECK(s.slab >= slabs / 2);
            }
        }
    }

    TEST_CASE("what lies outside of the picture is not sent") {
        gp::Camera camera = looking_down(300, 100, 0.25);
        camera.voxel_to_eye[3].x = 60;
        CHECK(draw(sphere(20), camera, false).counts.triangles_out == 0);
        camera.voxel_to_eye[3] = glm::dvec4(0, 0, 100, 1);
        CHECK(draw(sphere(20), camera, false).counts.triangles_out == 0);
    }

    TEST_CASE("no triangle is sent to a region of which it covers nothing by an edge's verdict") {
        // A thin diagonal touches 2 n - 1 of n x n regions, not all of its bounding box.
        Random random(1);
        const Triangle t = {vertex_at(0, 0, random), vertex_at(1024 * 16, 1023 * 16, random),
                            vertex_at(1024 * 16, 1024 * 16, random)};
        const gp::RegionGrid grid = gp::region_grid(1024, 1024, 0);
        gp::RegionPrograms programs;
        programs.begin_frame(64);
        programs.begin_slab(0, 0);
        gp::DrawScratch scratch;
        const auto counts =
            gp::draw_slab(slab_of(std::span(&t, 1)), gp::prepare(pixel_camera(1024, 1024)), grid,
                          {}, scratch, programs);
        CHECK(counts.triangles_out >= 8);
        CHECK(counts.triangles_out <= 15);
    }

    TEST_CASE("the second view goes to the regions behind those of the first") {
        Random random(1);
        const Triangle t = {vertex_at(0, 0, random), vertex_at(900, 0, random),
                            vertex_at(0, 900, random)};
        const gp::RegionGrid grid = gp::region_grid(256, 256, 1);
        CHECK(grid.first_region == 4);
        gp::RegionPrograms programs;
        programs.begin_frame(8);
        programs.begin_slab(0, 0);
        gp::DrawScratch scratch;
        gp::draw_slab(slab_of(std::span(&t, 1)), gp::prepare(pixel_camera(256, 256)), grid, {},
                      scratch, programs);
        CHECK(programs.regions()[4].word_count() == shape::word_count);
        CHECK(programs.regions()[0].word_count() == 0);
    }
}
