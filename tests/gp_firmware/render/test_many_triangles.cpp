// Slabs drawn in vectors, on every target, against their triangles one by one by the definition.
#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

#include "gp_firmware/geometry/clip.hpp"
#include "gp_firmware/render/set_up_triangles.hpp"
#include "isa/contract/vector_target.hpp"
#include "tests/gp_firmware/render/support.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

/// The drawn surface and the camera.
struct Scene {
    gp::SlabMesh mesh;
    gp::Camera camera;
    gp::RegionGrid grid;
    gp::SurfaceStyle style;
};

/// All regions' words and origins.
struct Streams {
    std::vector<std::vector<std::uint32_t>> words;
    std::vector<std::vector<gp::Origin>> origins;
    std::vector<std::vector<gp::Segment>> segments;
    std::uint32_t emitted = 0;
    friend bool operator==(const Streams&, const Streams&) = default;
};

/// Calls draw(programs), which returns how many triangles it emitted.
template <typename Draw>
Streams streams_of(const gp::RegionGrid& grid, const Draw& draw) {
    gp::RegionPrograms programs;
    programs.begin_frame(static_cast<std::size_t>(grid.count()), true);
    programs.begin_slab(3, 7);
    Streams streams;
    streams.emitted = draw(programs);
    programs.end_frame();
    for (std::size_t region = 0; region < programs.regions().size(); ++region) {
        const gp::RegionProgram& program = programs.regions()[region];
        streams.words.push_back(words_of(programs, region, grid));
        streams.origins.emplace_back(program.origins.values().begin(),
                                     program.origins.values().end());
        streams.segments.push_back(program.segments);
    }
    return streams;
}

Streams in_vectors(const Scene& scene, VectorTarget target) {
    return streams_of(scene.grid, [&](gp::RegionPrograms& programs) {
        gp::DrawScratch scratch;
        return gp::draw_slab(scene.mesh, gp::prepare(scene.camera), scene.grid, scene.style,
                             scratch, programs, target)
            .triangles_out;
    });
}

Streams one_by_one(const Scene& scene) {
    const gp::Projection projection = gp::prepare(scene.camera);
    const auto screen = gp::transformed(scene.mesh.vertices, projection);
    return streams_of(scene.grid, [&](gp::RegionPrograms& programs) {
        std::uint32_t emitted = 0;
        std::vector<ScreenVertex> polygon;
        for (std::size_t t = 0; t < scene.mesh.indices.size() / 3; ++t) {
            const std::uint32_t* index = &scene.mesh.indices[3 * t];
            const auto vertex = [&](std::size_t k) { return &scene.mesh.vertices[index[k]]; };
            const auto corner = [&](std::size_t k) { return &screen[index[k]]; };
            polygon = {*corner(0), *corner(1), *corner(2)};
            if ((polygon[0].outside | polygon[1].outside | polygon[2].outside) != 0) {
                gp::clip_triangle({vertex(0), vertex(1), vertex(2)},
                                  {corner(0), corner(1), corner(2)}, projection, polygon);
            }
            for (std::size_t k = 2; !gp::is_hidden(scene.style.hidden, t) && k < polygon.size();
                 ++k) {
                gp::Origin origin = scene.mesh.origins[t];
                origin.piece = static_cast<std::uint8_t>(k - 2);
                programs.set_origin(origin);
                emitted += gp::draw_screen_triangle(polygon[0], polygon[k - 1], polygon[k],
                                                    scene.grid, scene.style, programs);
            }
        }
        return emitted;
    });
}

/// A triangle of one of the kinds that the vectors' arithmetic could get wrong.
Triangle random_triangle(Random& random) {
    constexpr int picture = 512 * 16, guard = gp::guard_px * 16;
    const int kind = random.integer(0, 7);
    const auto around = [&](int x, int y, int spread) {
        return vertex_at(x + random.integer(-spread, spread), y + random.integer(-spread, spread),
                         random);
    };
    // Now and then at a region's border.
    const int x = random.integer(0, 3) > 0 ? random.integer(-40, picture + 40)
                                           : random.integer(0, 4) * 2048 + random.integer(-9, 9);
    const int y = random.integer(-40, picture + 40);
    const auto anywhere = [&] { return around(0, 0, guard); };
    if (kind < 3) {  // A pixel or two across, like most.
        const int spread = 4 << 2 * kind;
        return {around(x, y, spread), around(x, y, spread), around(x, y, spread)};
    }
    if (kind == 3) {  // Some regions across.
        return {around(x, y, 4000), around(x, y, 4000), around(x, y, 4000)};
    }
    if (kind == 4) {  // As large as vectors take, a little less or more.
        const int extent = gp::max_extent + random.integer(-2, 1);
        return {vertex_at(x, y, random), vertex_at(x - extent, y + random.integer(-9, 9), random),
                vertex_at(x - random.integer(0, extent), y - extent, random)};
    }
    if (kind == 5) {  // Long, of an area of next to nothing: the steepest slopes.
        const int times = random.integer(0, 4) * 2 + 1;
        const int n = random.integer(100, 16000 / times), right = random.integer(0, 1) * 2 - 1;
        Triangle t = {vertex_at(x, y, random), vertex_at(x + right * n, y + n - 1, random),
                      vertex_at(x + right * (n + 1) * times, y + n * times, random)};
        t[0].z = isa::region::z_margin;
        t[1].z = isa::region::z_far - isa::region::z_margin;
        return t;
    }
    if (kind == 6) {  // Of no area.
        const ScreenVertex v = around(x, y, 1000);
        return {v, around(x, y, 1000), v};
    }
    return {anywhere(), anywhere(), anywhere()};
}

/// Its own camera's picture of `count` triangles, each with its own origin.
Scene random_scene(int count, Random& random) {
    Scene scene;
    std::vector<Triangle> triangles;
    for (int i = 0; i < count; ++i) {
        triangles.push_back(random_triangle(random));
    }
    scene.mesh = slab_of(triangles);
    for (int i = 0; i < count; ++i) {
        scene.mesh.origins.push_back({static_cast<std::uint16_t>(i)});
    }
    scene.camera = pixel_camera(512, 512);
    scene.grid = gp::region_grid(512, 512, 0);
    scene.style = {3, random.integer(0, 1) == 1};
    return scene;
}

/// Compares all targets with the definition. Returns how many triangles were emitted.
std::uint32_t check_all_targets(const Scene& scene) {
    const Streams expected = one_by_one(scene);
    for (const VectorTarget target : isa::available_targets()) {
        INFO(std::string(enum_name(target)), ", seed ", seed());
        CHECK((in_vectors(scene, target) == expected));
    }
    return expected.emitted;
}

}  // namespace

TEST_SUITE("gp/many triangles") {
    TEST_CASE("vectors emit the words, origins and segments of triangles one by one") {
        Random random(11);
        std::uint32_t emitted = 0;
        for (const int count : {1, 3, 4, 5, 8, 15, 16, 17, 63, 64, 65, 200, 8000, 8000}) {
            emitted += check_all_targets(random_scene(count, random));
        }
        CHECK(emitted > 5000);
    }

    TEST_CASE("the same with planes that cut triangles off or through") {
        Random random(12);
        for (int round = 0; round < 4; ++round) {
            Scene scene = random_scene(1000, random);
            scene.camera.clip_planes = {{1, random.real(-0.3, 0.3), 0, -150},
                                        {random.real(-0.3, 0.3), 1, 0, -150}};
            CHECK(check_all_targets(scene) > 200);
        }
    }

    TEST_CASE("the same where a mask hides some") {
        Random random(13);
        Scene scene = random_scene(1001, random);
        std::vector<std::uint8_t> hidden(126);
        for (std::uint8_t& byte : hidden) {
            byte = static_cast<std::uint8_t>(random.integer(0, 255));
        }
        scene.style.hidden = hidden;
        const std::uint32_t shown = check_all_targets(scene);
        scene.style.hidden = {};
        CHECK(check_all_targets(scene) > shown + 100);
    }

    TEST_CASE("slopes that the definition divides in integers are among those that are compared") {
        Random random(11);
        int steep = 0;
        for (int i = 0; i < 20000; ++i) {
            const auto t = oriented(random_triangle(random));
            if (!t) {
                continue;
            }
            const auto slopes = gp::setup::slopes_of((*t)[0], (*t)[1], (*t)[2],
                                                     gp::determinant((*t)[0], (*t)[1], (*t)[2]));
            // Rounded doubles keep their exponent in the upper bits.
            steep += slopes.a[0] >> 52 == 0 || slopes.a[0] >> 52 == 0xFFF ? 1 : 0;
        }
        CHECK(steep > 100);
    }

    TEST_CASE("every covered pixel shape of up to four pixels is found") {
        Random random(14);
        // Of any height and width, so that any of the pixels is often the only one; every other
        // one on a lattice of half pixels, where centers lie on edges.
        std::vector<Triangle> triangles;
        for (int i = 0; i < 30000; ++i) {
            const int width = random.integer(1, 5), height = random.integer(1, 5);
            const int step = i % 2 == 0 ? 8 : 1;
            const auto corner = [&] {
                return vertex_at(2000 + random.integer(0, width * 16 / step) * step,
                                 2000 + random.integer(0, height * 16 / step) * step, random);
            };
            triangles.push_back({corner(), corner(), corner()});
        }
        Scene scene = random_scene(1, random);
        scene.mesh = slab_of(triangles);
        scene.mesh.origins.resize(triangles.size());
        scene.style.cull_back = false;
        CHECK(check_all_targets(scene) > 2000);
    }
}
