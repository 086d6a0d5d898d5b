// Simplified surfaces on a simulated machine: the same on machines of any size, near the exact
// surface, and gone when pictures are exact again.
#include <doctest/doctest.h>

#include <optional>
#include <string>
#include <vector>

#include "host/session/transfer/detail.hpp"
#include "host/surface/certificate.hpp"
#include "host/surface/mesh_distance.hpp"
#include "host/surface/patient_mesh.hpp"
#include "ringbus/rules/slabs.hpp"
#include "tests/system/surfaces/bone.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using test::Bone;
using test::machine_of;

namespace {

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

/// Pictures and their bounds.
struct Seen {
    std::vector<std::vector<std::uint32_t>> pictures;
    std::vector<double> moved_mm;
    bool operator==(const Seen&) const = default;
};

/// Corners and centers of every `step`th triangle.
std::vector<glm::vec3> samples_of(const WeldedMesh& mesh, std::size_t step) {
    std::vector<glm::vec3> samples;
    for (std::size_t t = 0; t < mesh.triangles.size(); t += step) {
        const auto& [a, b, c] = mesh.triangles[t];
        samples.insert(samples.end(), {mesh.p_grid[a], mesh.p_grid[b], mesh.p_grid[c],
                                       (mesh.p_grid[a] + mesh.p_grid[b] + mesh.p_grid[c]) / 3.0F});
    }
    return samples;
}

}  // namespace

TEST_CASE("a simplified picture and its bound are the same on machines of any size") {
    Seen first;
    const struct {
        int gps, renderers, slabs_per_set;
        std::uint64_t seed;
    } machines[] = {{1, 1, 1, 1}, {2, 2, 16, 2}, {3, 4, 16, 3}, {2, 3, 32, 4}};
    for (const auto& m : machines) {
        CAPTURE(m.gps);
        Bone bone(machine_of(m.gps, m.renderers, m.seed), m.slabs_per_set);
        Seen seen;
        for (const char* line : {"detail 1", "detail 2", "detail 3", "clip L",
                                 "components bone show=largest", "antialias 4"}) {
            bone.run(line);
            seen.pictures.push_back(bone.draw());
            seen.moved_mm.push_back(bone.moved_mm());
        }
        if (first.pictures.empty()) {
            first = seen;
        }
        CHECK(seen == first);
    }
    CHECK(first.moved_mm[0] > 0);
    CHECK(first.moved_mm[1] > first.moved_mm[0]);
    CHECK(first.moved_mm[2] > first.moved_mm[1]);
    CHECK(first.pictures[1] != first.pictures[0]);
    CHECK(first.pictures[4] != first.pictures[3]);
}

TEST_CASE("exact pictures stay exact, also after simplified ones and with detail auto") {
    Bone bone(machine_of(2, 2, 5), block_slabs);
    const auto exact = bone.draw();
    CHECK(bone.moved_mm() == 0);
    bone.run("detail 3");
    CHECK(bone.draw() != exact);
    CHECK(bone.moved_mm() > 0);
    const std::optional<Frames::Picked> hit = bone.session.frames.pick(100, 85);
    bone.run("detail auto");
    CHECK(bone.draw() == exact);
    CHECK(bone.moved_mm() == 0);
    bone.run("detail exact");
    CHECK(bone.draw() == exact);
    REQUIRE(hit);  // A pick asks the exact surface, whatever the pictures show.
    CHECK(bone.session.frames.pick(100, 85)->pick.p_mm == hit->pick.p_mm);
}

TEST_CASE("a simplified mesh is watertight and no farther from the exact mesh than its bound") {
    Bone bone(machine_of(2, 1, 6), block_slabs);
    const Surface surface = bone.session.meshes.surface("bone");
    const VolumeGrid grid = bone.session.meshes.grid();
    WeldedMesh exact = bone.session.meshes.fetch("bone");
    const Certificate before = certify(exact, grid);
    move_to_patient(exact, grid);
    for (int detail = 1; detail <= max_detail; ++detail) {
        CAPTURE(detail);
        SimplifiedMesh got = bone.session.meshes.fetch_simplified(surface, detail);
        const Certificate certificate = certify(got.mesh, grid);
        CHECK(certificate.watertight_but_for_border());
        CHECK(certificate.watertight() == before.watertight());
        CHECK(certificate.count(DefectKind::open_edge) == 0);
        CHECK(certificate.triangles < before.triangles / (1 << detail));
        move_to_patient(got.mesh, grid);
        const double most_mm =
            farthest_distance(samples_of(got.mesh, 1), exact.p_grid, exact.triangles);
        CHECK(most_mm > 0);
        CHECK(most_mm <= got.moved_mm + 1e-4);
    }
}

TEST_CASE("simplification is refused where blocks are spread over GPs, with the remedy") {
    Bone bone(machine_of(2, 1, 7), 1);
    for (const char* line : {"detail 1", "export refused.stl detail=1"}) {
        const std::string refused = bone.refusal(line);
        CAPTURE(line);
        CHECK(has(refused, "each GP has sets of 1 slab,"));
        CHECK(has(refused, "a block of 16 slabs must be in one of the 2 GPs"));
        CHECK(has(refused, "--set gp.slabs_per_set=16"));
    }
    CHECK(bone.session.scene.detail == DetailChoice{});
    const Reply automatic = bone.run("detail auto");
    REQUIRE(automatic.warnings.size() == 1);
    CHECK(has(automatic.warnings[0], "all pictures are exact"));
    const auto exact = bone.draw();
    bone.session.scene.detail = {false, 2};  // For example from before a load or a scaling.
    CHECK(bone.draw() == exact);
    CHECK(bone.moved_mm() == 0);
}

TEST_CASE("export refuses what starts from the exact surface") {
    Bone bone(machine_of(1, 1, 8), block_slabs);
    CHECK(has(bone.refusal("export refused.stl detail=2 cap=yes"),
              "detail=2 and cap=yes cannot be combined"));
    CHECK(has(bone.refusal("export refused.stl detail=2 keep=0.5"),
              "detail=2 and keep= cannot be combined"));
}

TEST_CASE("a script repeats the detail, and undo passes over it") {
    Bone bone(machine_of(1, 1, 9), block_slabs);
    bone.run("view 30 10");
    bone.run("detail 2");
    CHECK(has(bone.session.history.script(), "detail 2\n"));
    CHECK(bone.session.history.undo_line() == "view 30 10");
}

TEST_CASE("a bound is written no smaller than it is") {
    CHECK(bound_text(7.1131) == "7.114");
    CHECK(bound_text(0.125) == "0.125");
    CHECK(bound_text(0.0001) == "0.001");
}

TEST_CASE("moving pictures get the least detail that keeps them within their budget") {
    CHECK(moving_detail(0) == 0);
    CHECK(moving_detail(moving_triangles) == 0);
    CHECK(moving_detail(moving_triangles + 1) == 1);
    CHECK(moving_detail(4 * moving_triangles) == 1);
    CHECK(moving_detail(4 * moving_triangles + 1) == 2);
    CHECK(moving_detail(1000 * moving_triangles) == max_detail);
}
