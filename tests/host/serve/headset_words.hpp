// Messages of a headset, for tests.
#pragma once

#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>

#include "host/scene/camera.hpp"
#include "host/scene/stereo.hpp"

namespace pxpl5::test {

/// The elements of a matrix as the page sends them, column by column.
inline nlohmann::json elements_of(const glm::dmat4& matrix) {
    nlohmann::json elements = nlohmann::json::array();
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 4; ++row) {
            elements.push_back(matrix[column][row]);
        }
    }
    return elements;
}

/// Eyes 64 mm apart that look at the subject's center from an angle, with frusta that differ.
inline host::Eyes eyes_at(const host::Subject& subject, double azimuth_deg) {
    const double distance_mm = host::camera_distance_mm(subject);
    const auto matrices = host::camera_matrices({{azimuth_deg, 10}}, subject, 1);
    host::Eyes eyes{matrices, matrices};
    constexpr double half_mm = 32;
    for (const double side : {-1.0, 1.0}) {
        host::CameraMatrices& eye = side < 0 ? eyes.left : eyes.right;
        eye.patient_to_eye =
            glm::translate(glm::dmat4(1), glm::dvec3(-side * half_mm, 0, 0)) * eye.patient_to_eye;
        eye.projection[2][0] = -side * eye.projection[0][0] * half_mm / distance_mm;
        eye.projection[2][1] = side * 0.01;
    }
    return eyes;
}

inline nlohmann::json eye_words(const host::CameraMatrices& eye) {
    return {{"patient_to_eye", elements_of(eye.patient_to_eye)},
            {"projection", elements_of(eye.projection)}};
}

/// The message "eyes".
inline nlohmann::json eyes_message(int id, int pose, const host::Eyes& eyes, int width = 96,
                                   int height = 80) {
    return {{"id", id},
            {"eyes",
             {{"pose", pose},
              {"size", {width, height}},
              {"left", eye_words(eyes.left)},
              {"right", eye_words(eyes.right)}}}};
}

}  // namespace pxpl5::test
