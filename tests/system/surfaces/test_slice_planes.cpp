// Slices of the volume in pictures: their gray values, and that everything else takes account of
// them.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "host/scene/pick.hpp"
#include "tests/system/surfaces/bone.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using pxpl5::test::Bone;
using pxpl5::test::machine_of;

namespace {

constexpr double black = -160, white = 240;  // A window of 400 around 40.

double gray_of(double value) {
    return 255 * std::clamp((value - black) / (white - black), 0.0, 1.0);
}

/// The gray value of a plane at p, as its triangles interpolate those of the voxels: each square of
/// voxels has two, which share the diagonal from its first corner.
double plane_gray(const Volume& volume, const glm::dvec3& p, int axis) {
    const int across = axis == 0 ? 1 : 0, down = axis == 2 ? 1 : 2;
    glm::ivec3 first(0);
    first[axis] = static_cast<int>(std::lround(p[axis]));
    const glm::ivec3 size(volume.nx, volume.ny, volume.nz);
    for (const int side : {across, down}) {
        first[side] = std::clamp(static_cast<int>(std::floor(p[side])), 0, size[side] - 2);
    }
    const double u = p[across] - first[across], v = p[down] - first[down];
    const auto voxel = [&](int du, int dv) {
        glm::ivec3 at = first;
        at[across] += du;
        at[down] += dv;
        return gray_of(voxel_value(volume, at.x, at.y, at.z));
    };
    const double origin = voxel(0, 0), corner = u >= v ? voxel(1, 0) : voxel(0, 1);
    return u >= v ? origin + u * (corner - origin) + v * (voxel(1, 1) - corner)
                  : origin + v * (corner - origin) + u * (voxel(1, 1) - corner);
}

/// Compares the picture of one plane with the voxels. Vertices are snapped to 1/16 pixel, and a
/// pick's depth has steps, so a gray value may be that of a place up to 0.1 voxels away.
///
/// Returns  The number of compared pixels.
int compare_with_voxels(Bone& bone, int axis) {
    constexpr double near_voxels = 0.1;
    const std::vector<std::uint32_t> picture = bone.draw();
    const Volume& volume = bone.session.volumes.volume();
    int compared = 0;
    for (int y = 3; y < 170; y += 9) {
        for (int x = 3; x < 200; x += 9) {
            const auto hit = bone.session.frames.pick(x, y);
            if (!hit) {
                continue;
            }
            REQUIRE(hit->plane);
            const std::uint32_t rgba = picture[static_cast<std::size_t>(y * 200 + x)];
            const int red = static_cast<int>(rgba & 255);
            CHECK(static_cast<int>(rgba >> 8 & 255) == red);
            CHECK(static_cast<int>(rgba >> 16 & 255) == red);
            double least = 255, most = 0;
            for (const double across : {-near_voxels, 0.0, near_voxels}) {
                for (const double down : {-near_voxels, 0.0, near_voxels}) {
                    glm::dvec3 p = hit->pick.p_voxel;
                    p[axis == 0 ? 1 : 0] += across;
                    p[axis == 2 ? 1 : 2] += down;
                    const double near = plane_gray(volume, p, axis);
                    least = std::min(least, near);
                    most = std::max(most, near);
                }
            }
            CHECK(red >= least - 1);
            CHECK(red <= most + 1);
            ++compared;
        }
    }
    return compared;
}

}  // namespace

TEST_CASE("a slice in the picture has the gray values of its voxels") {
    Bone bone(machine_of(2, 2));
    bone.run("remove bone");
    for (const auto& [view, line, axis] :
         {std::tuple{"view superior", "planes z=21 window=400 level=40", 2},
          {"view 30 20", "planes z=0", 2},
          {"view anterior", "planes y=60 z=off", 1},
          {"view left", "planes x=70 y=off", 0},
          {"view -110 15 zoom=2", "planes x=5", 0}}) {
        CAPTURE(line);
        bone.run(view);
        bone.run(line);
        CHECK(compare_with_voxels(bone, axis) > 40);
    }
}

TEST_CASE("pictures with slices are the same for any machine") {
    const auto pictures_of = [](const Topology& topology) {
        Bone bone(topology);
        bone.run("surface skin opacity=0.5");
        bone.run("planes x=64 y=50 z=20");
        std::vector<std::vector<std::uint32_t>> pictures;
        for (const char* line : {"view 30 20", "antialias 4", "antialias 1", "clip L",
                                 "stereo anaglyph", "light off"}) {
            bone.run(line);
            pictures.push_back(bone.draw());
        }
        return pictures;
    };
    const auto wanted = pictures_of(machine_of(1, 1));
    CHECK(wanted[0] != wanted[3]);
    CHECK(pictures_of(machine_of(2, 2)) == wanted);
    CHECK(pictures_of(machine_of(3, 5, 7)) == wanted);
    CHECK(pictures_of(machine_of(36, 16)) == wanted);
}

TEST_CASE("a slice hides what lies behind it, and leaves nothing behind when it goes") {
    Bone bone(machine_of(2, 2));
    bone.run("view superior");
    const auto before = bone.draw();
    bone.run("planes z=40");
    const auto covered = bone.draw();
    CHECK(covered != before);
    bone.run("planes window=50");
    CHECK(bone.draw() != covered);
    bone.run("planes off");
    CHECK(bone.draw() == before);
    bone.run("planes z=10 window=400 level=40");
    bone.run("load phantom:pelvis");
    CHECK(bone.session.scene.planes.empty());
}

TEST_CASE("a click on a slice means its point, not that of a surface behind it") {
    Bone bone(machine_of(2, 2));
    bone.run("view superior");
    bone.run("planes z=55");
    const Reply reply = bone.run("pick 100 85");
    CHECK_MESSAGE(reply.text.starts_with("slice z 55 at "), reply.text);
    const auto hit = bone.session.frames.pick(100, 85);
    REQUIRE(hit);
    CHECK(hit->surface.empty());
    CHECK(hit->plane == ScenePlane{2, 55});
    CHECK(hit->pick.p_voxel.z == doctest::Approx(55).epsilon(1e-3));
    int behind = 0;
    for (int x = 40; x < 160; x += 4) {
        const auto seen = bone.session.frames.pick(x, 85);
        const auto named = bone.session.frames.pick(x, 85, "bone");
        behind += seen && seen->plane && named ? 1 : 0;
        CHECK((!named || named->surface == "bone"));
    }
    CHECK(behind > 0);
    const Reply part = bone.run("pick 100 85 part=yes");
    REQUIRE(part.warnings.size() == 1);
    CHECK(part.warnings.front().find("slice z 55 is at (100, 85)") != std::string::npos);
    CHECK(bone.run("measure 100 85 104 85").text.find("from slice z 55 at ") != std::string::npos);
}

TEST_CASE("undo and redo change slices as one step of each line") {
    Bone bone(machine_of(1, 1));
    const auto before = bone.draw();
    bone.run("mark");
    bone.run("planes z=20");
    const auto with = bone.draw();
    bone.run("mark");
    bone.run("planes x=30 window=90");
    CHECK(bone.draw() != with);
    bone.run("undo");
    CHECK(bone.draw() == with);
    bone.run("undo");
    CHECK(bone.draw() == before);
    bone.run("redo");
    CHECK(bone.draw() == with);
}

TEST_CASE("wrong words about slices are refused and change nothing") {
    Bone bone(machine_of(1, 1));
    const auto before = bone.draw();
    CHECK(bone.refusal("planes z=9999").find("has no slice 9999 along z: give 0 to ") !=
          std::string::npos);
    CHECK(bone.refusal("planes x=-1").find("has no slice -1 along x") != std::string::npos);
    CHECK_FALSE(bone.refusal("planes y=1.5").empty());
    CHECK(bone.refusal("planes y=axial").find("y is 'axial', must be the number of a slice") !=
          std::string::npos);
    CHECK(bone.refusal("planes z=").find("z is '', must be") != std::string::npos);
    CHECK_FALSE(bone.refusal("planes on").empty());
    CHECK(bone.refusal("planes off z=3") == "planes off: takes no options");
    CHECK(bone.refusal("planes window=40").find("there is none") != std::string::npos);
    CHECK(bone.refusal("planes z=3 window=1e-12 level=1e12").find("too narrow") !=
          std::string::npos);
    CHECK(bone.draw() == before);
    CHECK(bone.run("planes").text == "pictures show no slices");
    CHECK(bone.run("planes z=off").text == "pictures show no slices");
    CHECK(bone.session.scene.planes_window == GrayWindow());
    CHECK(bone.run("planes z=3 x=off window=400 level=40").text ==
          "slices z 3 in pictures, window 400 level 40");
}
