#include <doctest/doctest.h>

#include <cmath>
#include <cstdlib>
#include <glm/vec4.hpp>
#include <vector>

#include "host/scene/stereo.hpp"

using namespace pxpl5::host;

namespace {

const Subject subject{{10, -20, 30}, 150};
constexpr double aspect = 1.25;

Camera tilted() {
    Camera camera;
    camera.angles = {33, 12};
    camera.zoom = 1.7;
    camera.roll_deg = 20;
    camera.pan_mm = {4, -7};
    return camera;
}

/// The place of a point in the picture, -1..1, and its distance from the eye along the view.
struct Seen {
    glm::dvec2 at;
    double distance_mm;
};

Seen seen(const CameraMatrices& camera, const glm::dvec3& p_mm) {
    const glm::dvec4 eye = camera.patient_to_eye * glm::dvec4(p_mm, 1);
    const glm::dvec4 clip = camera.projection * eye;
    return {glm::dvec2(clip) / clip.w, -eye.z};
}

std::uint32_t gray(std::uint32_t value) {
    return 0xff000000U | value << 16U | value << 8U | value;
}

}  // namespace

TEST_CASE("the parallax of a point is f e (1/C - 1/d) across, and nothing up or down") {
    const Camera camera = tilted();
    const CameraMatrices middle = camera_matrices(camera, subject, aspect);
    for (const Stereo& stereo :
         {Stereo{StereoMode::anaglyph, 0, 0}, Stereo{StereoMode::rows, 63, 400}}) {
        const EyePlaces places = eye_places(stereo, camera, subject);
        const std::vector<CameraMatrices> eyes = eye_matrices(middle, places);
        REQUIRE(eyes.size() == 2);
        for (const glm::dvec3& p_mm :
             {subject.center_mm, glm::dvec3(80, -20, 30), glm::dvec3(-50, 60, 100)}) {
            const Seen left = seen(eyes[0], p_mm), right = seen(eyes[1], p_mm),
                       between = seen(middle, p_mm);
            const double expected = middle.projection[0][0] * places.separation_mm *
                                    (1 / places.convergence_mm - 1 / between.distance_mm);
            CHECK(right.at.x - left.at.x == doctest::Approx(expected).epsilon(1e-9));
            CHECK(std::abs(right.at.y - left.at.y) < 1e-12);
            CHECK(left.distance_mm == doctest::Approx(right.distance_mm));
            CHECK((left.at.x + right.at.x) / 2 == doctest::Approx(between.at.x));
        }
    }
}

TEST_CASE("near points seem near: the left eye sees them farther to the right") {
    const Camera camera = tilted();
    const CameraMatrices middle = camera_matrices(camera, subject, aspect);
    const auto eyes = eye_matrices(middle, eye_places({}, camera, subject));
    const glm::dmat4 to_patient = glm::inverse(middle.patient_to_eye);
    const double distance_mm = camera_distance_mm(subject);
    const auto parallax = [&](double toward_mm) {
        const glm::dvec3 p_mm(to_patient * glm::dvec4(0, 0, -distance_mm + toward_mm, 1));
        return seen(eyes[1], p_mm).at.x - seen(eyes[0], p_mm).at.x;
    };
    CHECK(parallax(100) < 0);
    CHECK(std::abs(parallax(0)) < 1e-12);
    CHECK(parallax(-100) > 0);
    // A thirtieth of the height for the nearest point of the subject.
    const double in_heights = -parallax(subject.radius_mm) * aspect / 2;
    CHECK(in_heights == doctest::Approx(1.0 / 30).epsilon(0.1));
}

TEST_CASE("a larger zoom brings the eyes nearer to each other, and the user's values hold") {
    Camera camera;
    const EyePlaces wide = eye_places({}, camera, subject);
    camera.zoom = 4;
    CHECK(eye_places({}, camera, subject).separation_mm == doctest::Approx(wide.separation_mm / 4));
    CHECK(wide.convergence_mm == doctest::Approx(camera_distance_mm(subject)));
    const EyePlaces own = eye_places({StereoMode::rows, 63, 500}, camera, subject);
    CHECK(own.separation_mm == 63);
    CHECK(own.convergence_mm == 500);
}

TEST_CASE("a pair becomes one picture") {
    // Two rows of three pixels for each eye.
    const std::vector<std::uint32_t> pair{1, 2, 3, 4, 5, 6, 11, 12, 13, 14, 15, 16};
    const Size eye{3, 2};
    using Pixels = std::vector<std::uint32_t>;
    CHECK(composed(pair, eye, StereoMode::side_by_side) ==
          Pixels{1, 2, 3, 11, 12, 13, 4, 5, 6, 14, 15, 16});
    CHECK(composed(pair, eye, StereoMode::crossed) ==
          Pixels{11, 12, 13, 1, 2, 3, 14, 15, 16, 4, 5, 6});
    CHECK(composed(pair, eye, StereoMode::rows) == Pixels{1, 2, 3, 14, 15, 16});
    CHECK(composed_size(eye, StereoMode::side_by_side) == Size{6, 2});
    CHECK(composed_size(eye, StereoMode::crossed) == Size{6, 2});
    CHECK(composed_size(eye, StereoMode::anaglyph) == eye);
    CHECK(composed_size(eye, StereoMode::rows) == eye);
    CHECK(composed_size(eye, StereoMode::off) == eye);
    // Each pixel of a composed picture is found again in the pair.
    for (const StereoMode mode :
         {StereoMode::side_by_side, StereoMode::crossed, StereoMode::rows}) {
        const Size size = composed_size(eye, mode);
        const Pixels picture = composed(pair, eye, mode);
        for (int y = 0; y < size.height; ++y) {
            for (int x = 0; x < size.width; ++x) {
                const EyePixel pixel = eye_pixel(x, y, eye, mode);
                const int at = (pixel.eye * eye.height + pixel.y) * eye.width + pixel.x;
                CHECK(picture[static_cast<std::size_t>(y * size.width + x)] ==
                      pair[static_cast<std::size_t>(at)]);
            }
        }
    }
}

TEST_CASE("an anaglyph of two equal gray pictures is this picture, within 3 of 255") {
    std::vector<std::uint32_t> pair;
    for (std::uint32_t value = 0; value < 256; ++value) {
        pair.push_back(gray(value));
    }
    pair.insert(pair.end(), pair.begin(), pair.begin() + 256);
    const auto picture = composed(pair, {256, 1}, StereoMode::anaglyph);
    for (std::uint32_t value = 0; value < 256; ++value) {
        for (const unsigned shift : {0U, 8U, 16U}) {
            const auto shown = static_cast<int>(picture[value] >> shift & 0xffU);
            CHECK_MESSAGE(std::abs(shown - static_cast<int>(value)) <= 3, value);
        }
        CHECK((picture[value] >> 24U) == 0xffU);
    }
}

TEST_CASE("the left eye's light is red, the right eye's is cyan") {
    const std::vector<std::uint32_t> left{gray(255), gray(0)}, right{gray(0), gray(255)};
    const auto red = composed(left, {1, 1}, StereoMode::anaglyph).at(0);
    const auto cyan = composed(right, {1, 1}, StereoMode::anaglyph).at(0);
    CHECK((red & 0xffU) > 240);
    CHECK((red >> 8U & 0xffU) < 20);
    CHECK((red >> 16U & 0xffU) < 20);
    CHECK((cyan & 0xffU) < 20);
    CHECK((cyan >> 8U & 0xffU) > 240);
    CHECK((cyan >> 16U & 0xffU) > 240);
}

TEST_CASE("the words of the modes are read back") {
    for (const StereoMode mode : {StereoMode::off, StereoMode::anaglyph, StereoMode::side_by_side,
                                  StereoMode::crossed, StereoMode::rows}) {
        CHECK(find_stereo(stereo_word(mode)) == mode);
    }
    CHECK(!find_stereo("headset"));
}
