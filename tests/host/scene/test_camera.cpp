#include <doctest/doctest.h>

#include <cmath>
#include <glm/glm.hpp>

#include "host/scene/camera.hpp"

using namespace pxpl5::host;

namespace {

const Subject subject{{10, -20, 30}, 100};

/// Normalized device coordinates of a point in patient millimeters.
glm::dvec3 project(const Camera& camera, glm::dvec3 p_mm, double aspect = 1) {
    const CameraMatrices m = camera_matrices(camera, subject, aspect);
    const glm::dvec4 clip = m.projection * m.patient_to_eye * glm::dvec4(p_mm, 1);
    return glm::dvec3(clip) / clip.w;
}

/// Where the picture shows a point that lies `step_mm` from the subject's center.
glm::dvec3 seen(const char* view, glm::dvec3 step_mm) {
    return project({find_view(view).value(), 1}, subject.center_mm + step_mm);
}

const glm::dvec3 left{50, 0, 0}, back{0, 50, 0}, head{0, 0, 50};

}  // namespace

TEST_SUITE("host/camera") {
    TEST_CASE("the subject's center is in the middle of every view") {
        for (const NamedView& view : named_views()) {
            const glm::dvec3 p = seen(view.name.data(), {0, 0, 0});
            CHECK(p.x == doctest::Approx(0));
            CHECK(p.y == doctest::Approx(0));
        }
    }

    TEST_CASE("each named view shows the patient's axes where an anatomist expects them") {
        CHECK(seen("anterior", left).x > 0.1);
        CHECK(seen("anterior", head).y > 0.1);
        CHECK(seen("posterior", left).x < -0.1);
        CHECK(seen("posterior", head).y > 0.1);
        CHECK(seen("left", back).x > 0.1);
        CHECK(seen("left", head).y > 0.1);
        CHECK(seen("right", back).x < -0.1);
        CHECK(seen("right", head).y > 0.1);
        CHECK(seen("inferior", left).x > 0.1);
        CHECK(seen("inferior", back).y < -0.1);
        CHECK(seen("superior", left).x < -0.1);
        CHECK(seen("superior", back).y < -0.1);
    }

    TEST_CASE("what is nearer to the viewer has the smaller depth") {
        CHECK(seen("anterior", -back).z < seen("anterior", back).z);
        CHECK(seen("left", left).z < seen("left", -left).z);
        CHECK(seen("superior", head).z < seen("superior", -head).z);
    }

    TEST_CASE("the subject's sphere lies between the near and the far plane") {
        for (const double side : {-1.0, 1.0}) {
            const glm::dvec3 p = seen("anterior", {0, side * subject.radius_mm, 0});
            CHECK(p.z > -1);
            CHECK(p.z < 1);
        }
    }

    TEST_CASE("zoom and aspect scale the picture, not the depth") {
        const glm::dvec3 p = subject.center_mm + glm::dvec3(20, -5, 30);
        const glm::dvec3 once = project({{0, 0}, 1}, p), twice = project({{0, 0}, 2}, p);
        CHECK(twice.x == doctest::Approx(2 * once.x));
        CHECK(twice.y == doctest::Approx(2 * once.y));
        CHECK(twice.z == doctest::Approx(once.z));
        CHECK(project({{0, 0}, 1}, p, 2).x == doctest::Approx(once.x / 2));
        CHECK(project({{0, 0}, 1}, p, 0.5).y == doctest::Approx(once.y / 2));
    }

    TEST_CASE("the subject of a sheared, reflected volume is its box's sphere") {
        glm::dmat4 affine(1.0);
        affine[0] = {-2, 0, 0, 0};
        affine[2] = {0, 1, 3, 0};
        affine[3] = {5, 6, 7, 1};
        const Subject found = subject_of(3, 5, 3, affine);
        CHECK(found.center_mm.x == doctest::Approx(5 - 2));
        CHECK(found.center_mm.y == doctest::Approx(6 + 2 + 1));
        CHECK(found.center_mm.z == doctest::Approx(7 + 3));
        // The farthest corners from the center are at (+-2, +-(2 + 1), +-3).
        CHECK(found.radius_mm == doctest::Approx(std::sqrt(4.0 + 9 + 9)));
    }

    TEST_CASE("a roll of 90 degrees turns the picture counter-clockwise") {
        Camera camera{find_view("anterior").value(), 1, 90};
        const glm::dvec3 p_left = project(camera, subject.center_mm + left);
        const glm::dvec3 p_head = project(camera, subject.center_mm + head);
        CHECK(p_left.y > 0.1);  // Was at the right, is above.
        CHECK(p_left.x == doctest::Approx(0));
        CHECK(p_head.x < -0.1);  // Was above, is at the left.
        CHECK(p_head.y == doctest::Approx(0));
    }

    TEST_CASE("a pan moves the center by so many millimeters, at any roll, zoom and aspect") {
        for (const double roll_deg : {0.0, 33.0, 180.0}) {
            const Camera camera{{20, 10}, 2, roll_deg, {12, -7}};
            const CameraMatrices m = camera_matrices(camera, subject, 1.5);
            const glm::dvec4 p_eye = m.patient_to_eye * glm::dvec4(subject.center_mm, 1);
            CHECK(p_eye.x == doctest::Approx(12));
            CHECK(p_eye.y == doctest::Approx(-7));
            // What lies beyond the pan the other way is in the middle.
            const Camera still{{20, 10}, 2, roll_deg};
            const glm::dvec4 middle =
                glm::inverse(camera_matrices(still, subject, 1.5).patient_to_eye) *
                glm::dvec4(-12, 7, p_eye.z, 1);
            const glm::dvec3 p = project(camera, glm::dvec3(middle), 1.5);
            CHECK(p.x == doctest::Approx(0));
            CHECK(p.y == doctest::Approx(0));
        }
    }
}
