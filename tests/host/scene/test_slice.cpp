// Slices: how they stand, and where surfaces cut them.
#include <doctest/doctest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/mat3x3.hpp>
#include <set>
#include <tuple>

#include "host/phantom/phantom.hpp"
#include "host/scene/slice.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

/// A volume whose voxels hold where they are in the patient: L + 10 P + 100 S, each 0, 1 or 2 steps
/// from the middle, plus 500.
Volume compass(const std::array<int, 3>& patient_axis, unsigned signs) {
    Volume v;
    v.nx = v.ny = v.nz = 5;
    v.type = Scalar::int16;
    glm::dmat3 directions(0.0);
    for (int axis = 0; axis < 3; ++axis) {
        directions[axis][patient_axis[static_cast<std::size_t>(axis)]] =
            (signs >> axis & 1) != 0 ? -1 : 1;
    }
    v.voxel_to_patient = glm::dmat4(directions);
    v.voxel_to_patient[3] = glm::dvec4(directions * glm::dvec3(-2), 1);
    for (int i = 0; i < 125; ++i) {
        const glm::dvec4 p = v.voxel_to_patient * glm::dvec4(i % 5, i / 5 % 5, i / 25, 1);
        const auto value = static_cast<std::int16_t>(500 + p.x + 10 * p.y + 100 * p.z);
        const auto bytes = std::bit_cast<std::array<std::byte, 2>>(value);
        v.values.insert(v.values.end(), bytes.begin(), bytes.end());
    }
    return v;
}

struct Expected {
    int right_step, down_step;  // Of the compass' values, one pixel on.
    std::array<const char*, 4> letters;
};
/// By the patient's axis that the slice stands across.
const std::array<Expected, 3> expected = {Expected{10, -100, {"A", "P", "S", "I"}},
                                          Expected{1, -100, {"R", "L", "S", "I"}},
                                          Expected{1, 10, {"R", "L", "A", "P"}}};

Slice slice_from(int width, int height, const std::vector<float>& values) {
    Slice slice;
    slice.frame.across.count = width;
    slice.frame.down.count = height;
    slice.type = Scalar::float32;
    slice.values.resize(values.size() * sizeof(float));
    std::memcpy(slice.values.data(), values.data(), slice.values.size());
    return slice;
}

std::vector<ContourPiece> contour(const Slice& slice, double isovalue,
                                  SaddleRule rule = SaddleRule::apart) {
    return slice_contour(slice.frame, numbers_of(slice), isovalue, rule);
}

double length_mm(const Slice& slice, const std::vector<ContourPiece>& pieces) {
    double sum = 0;
    for (const ContourPiece& p : pieces) {
        const glm::dvec2 d = glm::dvec2(p.to) - glm::dvec2(p.from);
        sum +=
            glm::length(d * glm::dvec2(slice.frame.across.spacing_mm, slice.frame.down.spacing_mm));
    }
    return sum;
}

}  // namespace

TEST_SUITE("slice") {
    TEST_CASE("stands as radiologists show it, whichever way the voxels run") {
        const std::array<std::array<int, 3>, 6> pairings = {
            {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
        for (const std::array<int, 3>& pairing : pairings) {
            for (unsigned signs = 0; signs < 8; ++signs) {
                const Volume volume = compass(pairing, signs);
                for (int axis = 0; axis < 3; ++axis) {
                    CAPTURE(pairing);
                    CAPTURE(signs);
                    CAPTURE(axis);
                    const Slice slice = slice_of(volume, axis, 3);
                    const std::vector<double> n = numbers_of(slice);
                    const Expected& e = expected.at(
                        static_cast<std::size_t>(pairing.at(static_cast<std::size_t>(axis))));
                    CHECK(n[12 + 1] - n[12] == e.right_step);
                    CHECK(n[12 + 5] - n[12] == e.down_step);
                    CHECK(slice.frame.across.begin == e.letters[0]);
                    CHECK(slice.frame.across.end == e.letters[1]);
                    CHECK(slice.frame.down.begin == e.letters[2]);
                    CHECK(slice.frame.down.end == e.letters[3]);
                }
            }
        }
    }
    TEST_CASE("the phantom's L reads as an L from the front") {
        // Its foot goes to the patient's left at the lower end: on the picture's lower right.
        const Volume letters = make_phantom("phantom:letters");
        const Slice slice = slice_of(letters, 1, letters.ny / 2);
        const std::vector<double> n = numbers_of(slice);
        const int w = slice.frame.across.count, h = slice.frame.down.count;
        const auto at = [&](double x, double y) {
            return n[static_cast<std::size_t>(y * h) * static_cast<std::size_t>(w) +
                     static_cast<std::size_t>(x * w)] >= 500.5;
        };
        CHECK(at(0.3, 0.3));
        CHECK(!at(0.7, 0.3));
        CHECK(at(0.3, 0.7));
        CHECK(at(0.7, 0.7));
    }
    TEST_CASE("an oblique slice takes the nearest of the patient's planes") {
        Volume volume = compass({0, 1, 2}, 0);
        const double turn = 0.6;  // About the patient's x, under 45 degrees.
        volume.voxel_to_patient = glm::dmat4(1.0);
        volume.voxel_to_patient[1] = glm::dvec4(0, std::cos(turn), std::sin(turn), 0);
        volume.voxel_to_patient[2] = glm::dvec4(0, -std::sin(turn), std::cos(turn), 0);
        const SliceFrame frame = slice_frame(volume, 2);
        CHECK(frame.across.end == "L");
        CHECK(frame.down.end == "PS");
        CHECK(frame.skew_deg == doctest::Approx(0));
    }
    TEST_CASE("a tilted gantry is told of") {
        Volume volume = compass({0, 1, 2}, 0);
        volume.voxel_to_patient[2] = glm::dvec4(0, std::sin(0.2), std::cos(0.2), 0);
        CHECK(slice_frame(volume, 0).skew_deg == doctest::Approx(0.2 / glm::pi<double>() * 180));
        CHECK(slice_frame(volume, 2).skew_deg == doctest::Approx(0));
    }
    TEST_CASE("unevenly spaced slices keep their places, from the picture's top") {
        Volume volume = compass({0, 1, 2}, 0);
        volume.voxel_to_patient[2] *= 2.0;  // 2 mm a step of the grid.
        volume.slice_places = {0, 1, 2, 5, 6};
        const SliceSide down = slice_frame(volume, 1).down;  // Superior, the last slice, on top.
        CHECK(down.is_flipped);
        CHECK(down.places_mm == std::vector<double>{0, 2, 8, 10, 12});
        CHECK(down.spacing_mm == doctest::Approx(3));
        CHECK(down.place_mm(1.5) == doctest::Approx(5));
        CHECK(down.number_at(5) == doctest::Approx(1.5));
        CHECK(slice_frame(volume, 1).across.places_mm.empty());
        CHECK(slice_frame(volume, 2).down.places_mm.empty());
    }
}

TEST_SUITE("contour") {
    TEST_CASE("of a sphere is a circle of its radius") {
        const Volume sphere = make_phantom("phantom:sphere");
        for (const int axis : {0, 1, 2}) {
            const std::array counts = {sphere.nx, sphere.ny, sphere.nz};
            const int count = counts.at(static_cast<std::size_t>(axis));
            for (const int index : {count / 2, count / 3}) {
                // Radius 30 mm about (0.3, -0.7, 0.45), as the phantom is documented.
                const glm::dvec3 center(0.3, -0.7, 0.45);
                glm::dvec4 p_voxel(0, 0, 0, 1);
                p_voxel[axis] = index;
                const double off = (sphere.voxel_to_patient * p_voxel)[axis] - center[axis];
                const double radius = std::sqrt(30.0 * 30.0 - off * off);
                const Slice slice = slice_of(sphere, axis, index);
                CHECK(length_mm(slice, contour(slice, 0.5)) ==
                      doctest::Approx(2 * glm::pi<double>() * radius).epsilon(0.01));
            }
        }
    }
    TEST_CASE("is closed, with the inside on its right") {
        const Volume torus = make_phantom("phantom:torus");
        const Slice slice = slice_of(torus, 2, torus.nz / 2);
        const std::vector<ContourPiece> pieces = contour(slice, 30000.5);
        const auto key = [](glm::vec2 p) { return std::tuple(p.x, p.y); };
        std::multiset<std::tuple<float, float>> from, to;
        double twice_area = 0;
        for (const ContourPiece& p : pieces) {
            from.insert(key(p.from));
            to.insert(key(p.to));
            twice_area +=
                static_cast<double>(p.from.x) * p.to.y - static_cast<double>(p.from.y) * p.to.x;
        }
        CHECK(pieces.size() > 100);
        CHECK(from == to);
        CHECK(twice_area > 0);  // Clockwise as one sees it, y downwards: a ring around more than 0.
    }
    TEST_CASE("a value equal to the isovalue is inside, and the crossing is linear") {
        const Slice slice = slice_from(2, 2, {10, 0, 10, 0});
        const auto at_value = contour(slice, 10);
        REQUIRE(at_value.size() == 1);
        CHECK(at_value[0].from.x == 0);  // At the voxels themselves.
        CHECK(at_value[0].to.x == 0);
        CHECK(contour(slice, 10.5).empty());
        const auto between = contour(slice, 2.5);
        REQUIRE(between.size() == 1);
        CHECK(between[0].from.x == 0.75F);
        CHECK(contour(slice, 0).empty());
    }
    TEST_CASE("a saddle is parted, or follows the bilinear interpolation") {
        // Saddle at (10 * 6 - 0 * 0) / (10 + 6) = 3.75: joined below, parted above.
        const Slice slice = slice_from(2, 2, {10, 0, 0, 6});
        const auto cut_off = [&](double isovalue, SaddleRule rule) {
            const auto pieces = contour(slice, isovalue, rule);
            REQUIRE(pieces.size() == 2);
            // Which corner the first piece is nearest to: its ends are on both sides beside it.
            std::set<std::tuple<bool, bool>> corners;
            for (const ContourPiece& p : pieces) {
                const glm::vec2 m = (p.from + p.to) * 0.5F;
                corners.insert({m.x > 0.5F, m.y > 0.5F});
            }
            return corners;
        };
        const std::set<std::tuple<bool, bool>> inside = {{false, false}, {true, true}};
        const std::set<std::tuple<bool, bool>> outside = {{true, false}, {false, true}};
        CHECK(cut_off(3.5, SaddleRule::asymptotic) == outside);
        CHECK(cut_off(4, SaddleRule::asymptotic) == inside);
        CHECK(cut_off(3.75, SaddleRule::asymptotic) == inside);  // A tie parts, as in extraction.
        CHECK(cut_off(3.5, SaddleRule::apart) == inside);
    }
    TEST_CASE("what is no number is outside") {
        const float none = std::numeric_limits<float>::quiet_NaN();
        const auto pieces = contour(slice_from(2, 2, {1, none, none, none}), 0.5);
        REQUIRE(pieces.size() == 1);
        // The inside, at the top left, is on the right of who goes from the top to the left.
        CHECK(pieces[0].from == glm::vec2(0.5F, 0));
        CHECK(pieces[0].to == glm::vec2(0, 0.5F));
    }
}
