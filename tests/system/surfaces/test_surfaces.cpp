// Surfaces that are masked, transparent, cut or hidden, on a simulated machine: whatever its size
// and the order of arrival, and whatever came before.
#include <doctest/doctest.h>
#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "host/base/error.hpp"
#include "host/surface/atlas/isovalue_components.hpp"
#include "host/surface/certificate.hpp"
#include "host/surface/parts/own_volume.hpp"
#include "tests/system/surfaces/bone.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using test::Bone;
using test::machine_of;

namespace {

constexpr Color gray{160, 160, 160};

}  // namespace

TEST_CASE("masks, doors and cuts give the same picture on any machine, in any order of arrival") {
    std::vector<std::vector<std::uint32_t>> first;
    const struct {
        int gps, renderers;
        std::uint64_t seed;
    } machines[] = {{1, 1, 1}, {2, 2, 2}, {2, 2, 3}, {3, 5, 4}, {3, 5, 5}};
    for (const auto& m : machines) {
        CAPTURE(m.gps);
        CAPTURE(m.seed);
        Bone bone(machine_of(m.gps, m.renderers, m.seed));
        std::vector<std::vector<std::uint32_t>> pictures;
        for (const char* line :
             {"components bone show=largest", "surface skin opacity=0.4", "clip L", "compare bone",
              "compare bone off", "components bone show=all", "clip off"}) {
            bone.run(line);
            pictures.push_back(bone.draw());
        }
        if (first.empty()) {
            first = pictures;
        }
        CHECK(pictures == first);
    }
}

TEST_CASE("what is chosen of a surface's components stays chosen when the isovalue moves") {
    Bone chosen_first(machine_of(2, 2)), chosen_last(machine_of(2, 2));
    chosen_first.run("components bone show=largest");
    chosen_first.run("surface bone iso=260.5");
    chosen_last.run("surface bone iso=260.5");
    const auto whole = chosen_last.draw();
    chosen_last.run("components bone show=largest");
    CHECK(chosen_first.draw() == chosen_last.draw());
    CHECK(chosen_first.draw() != whole);
    chosen_first.run("components bone show=all");
    CHECK(chosen_first.draw() == whole);
}

TEST_CASE("a comparison leaves nothing behind") {
    Bone bone(machine_of(2, 2));
    const auto before = bone.draw();
    bone.run("compare bone");
    CHECK(bone.draw() != before);
    CHECK(bone.session.scene.surfaces.size() == 3);
    bone.run("compare bone off");
    CHECK(bone.draw() == before);
    CHECK(bone.session.scene.surfaces.size() == 1);
}

TEST_CASE("a comparison ends when its surface changes, goes, or is hidden already") {
    Bone bone(machine_of(2, 2)), other(machine_of(2, 2));
    bone.run("compare bone");
    bone.run("surface bone iso=300.5");
    other.run("surface bone iso=300.5");
    CHECK(bone.draw() == other.draw());
    bone.run("compare bone");
    bone.run("remove bone:watertight");
    CHECK(bone.draw() == other.draw());
    bone.run("surface bone visible=no");
    bone.run("compare bone");
    bone.run("compare bone off");
    CHECK_FALSE(bone.session.surfaces.find("bone")->visible);
    bone.run("compare bone");
    bone.run("remove bone");
    CHECK(bone.session.scene.surfaces.empty());
    for (int i = 0; i < 15; ++i) {
        bone.run("surface s" + std::to_string(i) + " iso=800.5");
    }
    CHECK_THROWS_AS(bone.run("compare s0"), RequestError);
    CHECK(bone.session.scene.surfaces.size() == 15);
}

TEST_CASE("a hidden surface is as if it were not there") {
    Bone bone(machine_of(2, 2));
    const auto before = bone.draw();
    bone.run("surface skin");
    CHECK(bone.draw() != before);
    bone.run("surface skin visible=no");
    CHECK(bone.draw() == before);
    CHECK(bone.session.scene.surfaces.size() == 2);
}

TEST_CASE("a picked point has the isovalue between its voxels") {
    Bone bone(machine_of(2, 2));
    int hits = 0;
    for (int x = 20; x < 180; x += 8) {
        if (const auto picked = bone.session.frames.pick(x, 85)) {
            ++hits;
            CHECK(picked->surface == "bone");
            // Trilinear between voxels, linear along the edges of a triangle: not the same, but
            // far less apart than bone and what is around it.
            CHECK(picked->pick.value_between.value() == doctest::Approx(250.5).epsilon(0.35));
        }
    }
    CHECK(hits > 3);
    CHECK_FALSE(bone.session.frames.pick(0, 0).has_value());
}

TEST_CASE("a pick chooses by surface: the holes of a screen door do not count") {
    Bone bone(machine_of(2, 2));
    std::vector<std::optional<Frames::Picked>> alone;
    const auto pick_row = [&](const std::string& surface) {
        std::vector<std::optional<Frames::Picked>> found;
        for (int x = 60; x < 76; ++x) {  // All columns of the 4 x 4 screen door.
            found.push_back(bone.session.frames.pick(x, 85, surface));
        }
        return found;
    };
    alone = pick_row("");
    REQUIRE(std::ranges::count_if(alone, [](const auto& hit) { return hit.has_value(); }) > 3);
    bone.run("surface skin opacity=0.4");
    const auto chosen = pick_row(""), skin = pick_row("skin");
    for (std::size_t i = 0; i < alone.size(); ++i) {
        CAPTURE(i);
        REQUIRE(skin[i].has_value());
        CHECK(skin[i]->surface == "skin");
        REQUIRE(chosen[i].has_value());
        if (alone[i]) {
            CHECK(chosen[i]->surface == "bone");
            CHECK(chosen[i]->pick.p_mm == alone[i]->pick.p_mm);
            CHECK(skin[i]->pick.depth < chosen[i]->pick.depth);
        } else {
            CHECK(chosen[i]->pick.p_mm == skin[i]->pick.p_mm);
        }
    }
    // A question changes neither the picture nor what is reported about the picture.
    const auto before = bone.draw();
    const FrameReport report = bone.session.frames.last();
    bone.session.frames.hits(60, 85);
    CHECK(bone.session.frames.last().frame == report.frame);
    CHECK(bone.session.frames.last().region_cycles == report.region_cycles);
    CHECK(bone.draw() == before);
}

TEST_CASE("pick lists all surfaces under the pixel, and measure and components choose like pick") {
    Bone bone(machine_of(2, 2));
    bone.run("surface skin opacity=0.4");
    std::string at;
    for (int x = 20; at.empty() && x < 180; ++x) {
        if (bone.session.frames.pick(x, 85, "bone")) {
            at = std::to_string(x) + " 85";
        }
    }
    REQUIRE_FALSE(at.empty());
    CHECK(bone.run("pick " + at).text.find("\nin front: skin at (") != std::string::npos);
    CHECK(bone.run("pick " + at + " surface=skin").text.find("\nbehind: bone at (") !=
          std::string::npos);
    CHECK(bone.run("measure " + at + " " + at).text.starts_with("0.00 mm"));
    const Reply depth = bone.run("measure " + at + " " + at + " from=skin to=bone");
    const auto distance = std::ranges::find(depth.fields, "distance_mm", &Field::name);
    REQUIRE(distance != depth.fields.end());
    CHECK(std::get<double>(distance->value) > 1);
    for (int x = 60; x < 64; ++x) {
        CHECK_NOTHROW(bone.run("components skin at=" + std::to_string(x) + ",85"));
    }
    const Reply picked = bone.run("pick " + at + " surface=bone part=yes");
    const auto part = std::ranges::find(picked.fields, "part", &Field::name);
    REQUIRE(part != picked.fields.end());
    const Fields& fields = std::get<Fields>(part->value);
    const auto volume_ml = std::ranges::find(fields, "volume_ml", &Field::name);
    REQUIRE(volume_ml != fields.end());
    // All components without their cavities have the volume of the surface.
    const auto picked_place = bone.session.frames.pick(std::stoi(at), 85, "bone");
    const ChosenComponent chosen = bone.session.meshes.component_at(
        bone.session.meshes.surface("bone"), picked_place.value().pick.p_mm);
    double sum_mm3 = 0;
    for (std::size_t i = 0; i < chosen.parts.components.size(); ++i) {
        if (!chosen.parts.components[i].cavity) {
            sum_mm3 += own_volume(chosen.parts, i).volume_mm3.value();
        }
    }
    CHECK(sum_mm3 == doctest::Approx(bone.session.surfaces.report_of("bone").volume_mm3));
    CHECK(std::get<double>(volume_ml->value) * 1000 ==
          doctest::Approx(own_volume(chosen.parts, chosen.number).volume_mm3.value()));
    CHECK(picked.text.find(fmt::format("\ncomponent {} of {}: ", chosen.number + 1,
                                       chosen.parts.components.size())) != std::string::npos);
    CHECK(bone.run("pick " + at).text.find("component") == std::string::npos);
    CHECK_THROWS_WITH_AS(bone.run("pick 10 10 surface=skim"), doctest::Contains("mean 'skin'"),
                         RequestError);
    bone.run("surface skin visible=no");
    CHECK_THROWS_WITH_AS(bone.run("pick 10 10 surface=skin"), doctest::Contains("is hidden"),
                         RequestError);
}

TEST_CASE("the atlas tells what the surfaces would be") {
    Bone bone(machine_of(3, 1));
    const std::vector<double> isovalues = {-300.5, -20.5, 250.5, 700.5};
    const auto rows = bone.session.meshes.measure(isovalues, CaseRule::watertight);
    const auto components = count_components(bone.session.volumes.volume(), isovalues);
    for (std::size_t i = 0; i < isovalues.size(); ++i) {
        const SurfaceReport report =
            bone.session.surfaces.set("s", isovalues[i], CaseRule::watertight, gray);
        CHECK(static_cast<std::int64_t>(rows[i].triangles) == report.triangles);
        CHECK(rows[i].area_mm2 == doctest::Approx(report.area_mm2).epsilon(1e-9));
        CHECK(rows[i].volume_mm3 == doctest::Approx(report.volume_mm3).epsilon(1e-9));
        const Certificate certificate =
            certify(bone.session.meshes.fetch("s"), bone.session.meshes.grid());
        CHECK(certificate.good());
        CHECK(certificate.components == components[i].surface());
    }
}

TEST_CASE("wrong words about surfaces are refused and change nothing") {
    Bone bone(machine_of(1, 1));
    const auto before = bone.draw();
    for (const char* line : {"surface bone opacity=0",
                             "surface bone visible=maybe",
                             "surface bone preset=bones",
                             "components bone show=some",
                             "components bone at=0,0",
                             "components skull",
                             "compare skull",
                             "compare bone on",
                             "clip X 3",
                             "clip box 1,1,1",
                             "clip box 9,9,9 1,1,1",
                             "tint holes",
                             "overlay maybe",
                             "pick 200 0",
                             "pick 1.5 2",
                             "certificate skull",
                             "export",
                             "atlas from=5 to=1",
                             "atlas steps=1",
                             "load phantom:pelvis crop=1:2",
                             "load phantom:pelvis resample=2x2x2 resample_mm=1,1,1",
                             "orbit 3 picture.png",
                             "light 1 0 0 intensity=3.8"}) {
        CAPTURE(line);
        CHECK_THROWS_AS(bone.run(line), RequestError);
    }
    CHECK(bone.draw() == before);
    bone.run("light off");
    bone.run("light 1 0 0 intensity=3.4");
    CHECK_NOTHROW(bone.draw());
    CHECK_THROWS_WITH_AS(bone.run("material ambient=0.6"),
                         doctest::Contains("all intensities add up to 4, 3.9 are the most"),
                         RequestError);
    CHECK_NOTHROW(bone.draw());
}

TEST_CASE("surfaces that do not fit into the GPs' memory look and measure the same") {
    const auto seen_by = [](const Topology& topology, std::int64_t& left_out,
                            std::string& warning) {
        Bone bone(topology);
        std::vector<std::vector<std::uint32_t>> pictures = {bone.draw()};
        for (const char* line : {"components bone show=largest", "stereo anaglyph", "clip L",
                                 "antialias 4", "surface bone iso=300.5"}) {
            const Reply reply = bone.run(line);
            warning += reply.warnings.empty() ? "" : reply.warnings.front();
            pictures.push_back(bone.draw());
        }
        const SurfaceReport report = bone.session.surfaces.report_of("bone");
        left_out = report.slabs_left_out;
        const Certificate proof =
            certify(bone.session.meshes.fetch("bone", true), bone.session.meshes.grid());
        return std::tuple(pictures, bone.session.meshes.digest("bone"), report.triangles,
                          report.area_mm2, proof.vertices, proof.volume_mm3);
    };
    std::int64_t left_out = 0;
    std::string warning;
    const auto whole = seen_by(machine_of(1, 1), left_out, warning);
    CHECK(left_out == 0);
    CHECK(warning.empty());
    Topology scarce = machine_of(1, 1);
    {
        const Bone bone(scarce);
        const auto bytes = bone.session.surfaces.report_of("bone").memory_bytes;
        scarce.gp_memory_mib = static_cast<int>(bytes >> 20) - 1;
    }
    CHECK(seen_by(scarce, left_out, warning) == whole);
    CHECK(left_out > 0);
    CAPTURE(warning);
    CHECK(warning.find(" slabs do not fit into the memory of the GPs, which extract them again for "
                       "each picture and mesh. About ") != std::string::npos);
    CHECK(warning.find(" GPs, or more memory for each (gp.memory_mib), would hold them") !=
          std::string::npos);
}
