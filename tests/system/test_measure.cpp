// Lengths as a user measures them, from random views, through transparent skin, behind clip planes
// and in slices, against the lengths of the shapes themselves.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <random>

#include "host/commands/commands.hpp"
#include "host/serve/director/inspector.hpp"
#include "tests/host/inspect/surface_truth.hpp"
#include "tests/system/known_shapes.hpp"
#include "tests/system/simulated_machine.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::test;
using nlohmann::json;

namespace {

constexpr int views = 100;
constexpr int most_tries = 2000;

Topology small_machine() {
    Topology topology;
    topology.gp.count = topology.renderer.count = 2;
    topology.frame_buffer.count = 1;
    topology.gp_memory_mib = 64;
    return topology;
}

/// A user's session and dice.
struct Desk {
    SimulatedMachine machine{small_machine()};
    Session session{machine};
    std::mt19937 random{test_seed(16)};

    json does(const std::string& line) {
        return json::parse(json_text(run_command(session, parse_line(line)).fields));
    }
    double between(double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    }
    int below(int count) { return std::uniform_int_distribution<int>(0, count - 1)(random); }
    /// Half of the least distance between voxels.
    double half_voxel_mm() const {
        const glm::dmat4& m = session.volumes.volume().voxel_to_patient;
        return std::min({glm::length(m[0]), glm::length(m[1]), glm::length(m[2])}) / 2;
    }

    /// Turns, zooms, moves and cuts.
    void look_somewhere() {
        does(fmt::format("view {:.3f} {:.3f} roll={:.2f} zoom={:.3f} pan={:.2f},{:.2f}",
                         between(-180, 180), between(-90, 90), between(-180, 180),
                         between(0.6, 2.5), between(-12, 12), between(-12, 12)));
        does(fmt::format("antialias {}", std::array{1, 4, 16}[static_cast<std::size_t>(below(3))]));
        does("clip off");
        for (int planes = below(3); planes > 0; --planes) {
            does(fmt::format("clip {} {:.2f}", "LRPASI"[below(6)], between(-25, 25)));
        }
    }
    Ray ray(int x, int y) const {
        const Size& size = session.scene.size;
        return ray_of(camera_matrices(session.scene.camera, session.frames.subject(),
                                      static_cast<double>(size.width) / size.height),
                      size, x, y);
    }
};

struct End {
    int x = 0, y = 0;
    std::string surface;
    glm::dvec3 p_mm{0};
};

/// A pixel whose surface point is known, by `know(ray, which, end)`; nothing if the view has none.
///
/// which   0 for the first end of a length, 1 for the second.
template <typename Know>
std::optional<End> known_end(Desk& desk, int which, const Know& know) {
    for (int i = 0; i < most_tries; ++i) {
        End end{desk.below(desk.session.scene.size.width),
                desk.below(desk.session.scene.size.height),
                {},
                {}};
        if (know(desk.ray(end.x, end.y), which, end)) {
            return end;
        }
    }
    return std::nullopt;
}

glm::dvec3 point(const json& p) {
    return {p[0], p[1], p[2]};
}

/// Measures between known ends of random views. Returns the largest error.
template <typename Know>
double check_views(Desk& desk, const std::string& options, const Know& know) {
    double worst_mm = 0;
    int measured = 0;
    for (int i = 0; i < most_tries && measured < views; ++i) {
        desk.look_somewhere();
        const auto a = known_end(desk, 0, know), b = known_end(desk, 1, know);
        if (!a || !b) {
            continue;
        }
        ++measured;
        const json said =
            desk.does(fmt::format("measure {} {} {} {}{}", a->x, a->y, b->x, b->y, options));
        const double known_mm = glm::distance(a->p_mm, b->p_mm);
        INFO("view ", i, ", pixels ", a->x, ",", a->y, " and ", b->x, ",", b->y, ": ", said.dump());
        CHECK(said["a_surface"] == a->surface);
        CHECK(said["b_surface"] == b->surface);
        const double error_mm = std::abs(said["distance_mm"].get<double>() - known_mm);
        CHECK(error_mm < desk.half_voxel_mm());
        CHECK(glm::distance(point(said["a_mm"]), a->p_mm) < desk.half_voxel_mm());
        CHECK(glm::distance(point(said["b_mm"]), b->p_mm) < desk.half_voxel_mm());
        worst_mm = std::max(worst_mm, error_mm);
    }
    CHECK(measured == views);
    return worst_mm;
}

constexpr double inner_mm = 30, skin_mm = 38;

/// A sphere in a transparent one that is 8 mm thicker.
struct SphereDesk : Desk {
    SphereDesk() {
        does("size 200x150");
        does("load phantom:sphere");
        does("surface skin iso=-799.5 opacity=0.4");
        does("surface inner iso=0.5");
    }
};

/// phantom:letters in transparent skin.
struct LettersDesk : Desk {
    LettersDesk() {
        does("size 200x150");
        does("load phantom:letters");
        does("surface surface");
        does("surface skin iso=100.5 opacity=0.3");
    }
};

/// A random slice as the page shows it: contours by surface, in slice pixels.
struct ShownSlice {
    glm::dmat4 voxel_to_patient;
    json told;
    int axis, index, width, height;
    std::map<std::string, std::vector<glm::dvec2>> contours;

    ShownSlice(Desk& desk, int through)
        : voxel_to_patient(desk.session.volumes.volume().voxel_to_patient), axis(through) {
        const Volume& volume = desk.session.volumes.volume();
        index = desk.below(std::array{volume.nx, volume.ny, volume.nz}[at_index(axis)]);
        const serve::Answer answer =
            serve::answer(desk.session, json{{"id", 1},
                                             {"ask", "slice"},
                                             {"axis", std::string(1, "xyz"[axis])},
                                             {"index", index}}
                                            .dump());
        told = json::parse(answer.json);
        width = told["width"];
        height = told["height"];
        std::size_t at = (at_index(width * height) * sizeof(std::int16_t) + 7) / 8 * 8;
        for (const json& contour : told["contours"]) {
            std::vector<std::array<float, 4>> pieces(contour["count"].get<std::size_t>());
            if (!pieces.empty()) {
                std::memcpy(pieces.data(), answer.bytes.data() + at, pieces.size() * 16);
            }
            at += pieces.size() * 16;
            for (const auto& [x0, y0, x1, y1] : pieces) {
                contours[contour["surface"].get<std::string>()].emplace_back(x0, y0);
            }
        }
    }
    /// The place of a slice pixel in the patient, as the page computes it.
    glm::dvec3 at(glm::dvec2 p) const {
        glm::dvec4 voxel(0, 0, 0, 1);
        for (int side = 0; side < 2; ++side) {
            const int last = (side == 0 ? width : height) - 1;
            voxel[told["axes"][at_index(side)].get<int>()] =
                told["flips"][at_index(side)].get<bool>() ? last - p[side] : p[side];
        }
        voxel[axis] = index;
        return voxel_to_patient * voxel;
    }
    static std::size_t at_index(int i) { return static_cast<std::size_t>(i); }
};

void check_length(Desk& desk, const glm::dvec3& a, const glm::dvec3& b, double known_mm,
                  double& worst_mm) {
    const json said =
        desk.does(fmt::format("measure {},{},{} {},{},{}", a.x, a.y, a.z, b.x, b.y, b.z));
    const double error_mm = std::abs(said["distance_mm"].get<double>() - known_mm);
    CHECK(error_mm < desk.half_voxel_mm());
    worst_mm = std::max(worst_mm, error_mm);
}

bool take_first(const Met& met, const char* surface, End& end) {
    if (met.points.empty()) {
        return false;
    }
    end.surface = surface;
    end.p_mm = met.points.front();
    return true;
}

}  // namespace

TEST_SUITE("measured lengths") {
    TEST_CASE("between points of a sphere in transparent skin, from 100 views") {
        SphereDesk desk;
        const double worst_mm = check_views(desk, "", [&](const Ray& ray, int, End& end) {
            const std::vector<SceneClip>& clips = desk.session.scene.clips;
            const Met inner = meet_sphere(ray, inner_mm, clips);
            const Met skin = meet_sphere(ray, skin_mm, clips);
            return inner.is_sure && skin.is_sure &&
                   (take_first(inner, "inner", end) || take_first(skin, "skin", end));
        });
        MESSAGE("largest error ", worst_mm, " mm");
    }
    TEST_CASE("from the skin to the sphere in it, from 100 views") {
        SphereDesk desk;
        const double worst_mm =
            check_views(desk, " from=skin to=inner", [&](const Ray& ray, int which, End& end) {
                const Met met =
                    meet_sphere(ray, which == 0 ? skin_mm : inner_mm, desk.session.scene.clips);
                return met.is_sure && take_first(met, which == 0 ? "skin" : "inner", end);
            });
        MESSAGE("largest error ", worst_mm, " mm");
    }
    TEST_CASE("between sides of the block with letters in transparent skin, from 100 views") {
        LettersDesk desk;
        const double worst_mm = check_views(desk, "", [&](const Ray& ray, int, End& end) {
            const Met met = meet_block(ray, desk.session.scene.clips);
            return met.is_sure && take_first(met, "surface", end);
        });
        MESSAGE("largest error ", worst_mm, " mm");
    }
    TEST_CASE("across spheres in 100 slices, through transparent skin") {
        SphereDesk desk;
        double worst_mm = 0;
        for (int measured = 0; measured < views;) {
            const ShownSlice slice(desk, desk.below(3));
            for (const auto& [surface, radius_mm] :
                 {std::pair{"inner", inner_mm}, std::pair{"skin", skin_mm}}) {
                const double off_mm = slice.at({0, 0})[slice.axis] - sphere_center_mm[slice.axis];
                const double round_mm = radius_mm * radius_mm - off_mm * off_mm;
                if (round_mm < 25) {  // Near the pole, the radius changes faster than the slices.
                    continue;
                }
                const std::vector<glm::dvec2>& contour = slice.contours.at(surface);
                REQUIRE(!contour.empty());
                const int any = desk.below(static_cast<int>(contour.size()));
                const glm::dvec3 from = slice.at(contour[static_cast<std::size_t>(any)]);
                const glm::dvec3 to = slice.at(*std::ranges::max_element(
                    contour, {}, [&](glm::dvec2 p) { return glm::distance(slice.at(p), from); }));
                check_length(desk, from, to, 2 * std::sqrt(round_mm), worst_mm);
                ++measured;
            }
        }
        MESSAGE("largest error ", worst_mm, " mm");
    }
    TEST_CASE("across the block with letters in 100 slices") {
        LettersDesk desk;
        double worst_mm = 0;
        int measured = 0;
        for (int i = 0; i < most_tries && measured < views; ++i) {
            ShownSlice slice(desk, desk.below(3));
            const int row = desk.below(slice.height);
            std::vector<glm::dvec2> on_row = slice.contours["surface"];
            std::erase_if(on_row, [row](glm::dvec2 p) { return p.y != row; });
            const glm::dvec3 begin = slice.at({-100, row}), end = slice.at({slice.width, row});
            const Met met = meet_block({begin, glm::normalize(end - begin)}, {});
            if (!met.is_sure || met.points.empty()) {
                continue;
            }
            INFO("axis ", slice.axis, ", index ", slice.index, ", row ", row);
            REQUIRE(on_row.size() == met.points.size());
            const auto [left, right] = std::ranges::minmax(on_row, {}, &glm::dvec2::x);
            check_length(desk, slice.at(left), slice.at(right),
                         glm::distance(met.points.front(), met.points.back()), worst_mm);
            ++measured;
        }
        CHECK(measured == views);
        MESSAGE("largest error ", worst_mm, " mm");
    }
    TEST_CASE("from a place of a slice to a pixel of the picture") {
        SphereDesk desk;
        const json told = desk.does("pick 100 75");
        const glm::dvec3 p = point(told["p_mm"]);
        const json said = desk.does(fmt::format("measure {},{},{} 100 75", p.x + 3, p.y, p.z + 4));
        CHECK(said["distance_mm"].get<double>() == doctest::Approx(5));
        CHECK(said["a_surface"] == "");
        CHECK(said["b_surface"] == "inner");
        for (const char* line : {"measure 1 2", "measure 1,2,3 4", "measure 1,2,3 4,5,6 7",
                                 "measure 1 2,3,4", "measure 1 2 3 4,5,6", "measure 1,2 3,4"}) {
            CHECK_THROWS_AS_MESSAGE(desk.does(line), RequestError, line);
        }
    }
}
