#include "host/serve/director/headset_eyes.hpp"

#include <fmt/core.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "host/base/command_line.hpp"
#include "host/scene/scene.hpp"

namespace pxpl5::host::serve {

namespace {

using Json = nlohmann::json;

constexpr std::size_t elements = 16;
constexpr double exact = 1e-6;  ///< Error of an element that must be 0, 1 or -1.
/// Least element of a projection: a field of view of 179 degrees.
constexpr double min_scale = 0.01;
constexpr double max_scale = 1000;   ///< A field of view of 0.1 degrees.
constexpr double max_offset = 1000;  ///< Place of the middle, in halves of the picture.

/// The value of a key. Throws RequestError if the key does not exist.
const Json& part(const Json& object, const std::string& path, const char* key) {
    if (!object.is_object() || !object.contains(key)) {
        refuse_command(fmt::format("message: {}.{} is missing", path, key));
    }
    return object[key];
}

std::uint32_t whole(const Json& number, const std::string& name, std::uint32_t low,
                    std::uint32_t high) {
    const bool fits = number.is_number_unsigned() && number.get<std::uint64_t>() >= low &&
                      number.get<std::uint64_t>() <= high;
    if (!fits) {
        const std::string given = number.is_number() ? number.dump() : number.type_name();
        refuse_command(fmt::format("message: {} is {}, must be a whole number from {} to {}", name,
                                   given, low, high));
    }
    return number.get<std::uint32_t>();
}

void check_within(const std::string& name, double value, double low, double high) {
    if (!(value >= low && value <= high)) {
        refuse_command(
            fmt::format("message: {} is {:g}, must be from {:g} to {:g}", name, value, low, high));
    }
}

/// A column-major matrix and its name in errors.
struct Matrix {
    std::string name;
    std::array<double, elements> values{};

    double at(std::size_t element) const { return values.at(element); }
    std::string name_of(std::size_t element) const { return fmt::format("{}[{}]", name, element); }
    void check_equal(std::size_t element, double wanted, const char* why) const {
        if (!(std::abs(at(element) - wanted) <= exact)) {
            refuse_command(fmt::format("message: {} is {:g}, must be {:g}, because {}",
                                       name_of(element), at(element), wanted, why));
        }
    }
    void check_element(std::size_t element, double low, double high) const {
        check_within(name_of(element), at(element), low, high);
    }
    glm::dmat4 matrix() const {
        glm::dmat4 m;
        for (std::size_t i = 0; i < elements; ++i) {
            m[static_cast<int>(i / 4)][static_cast<int>(i % 4)] = values.at(i);
        }
        return m;
    }
};

/// The kind of a value, for errors: "a list of 3 elements" or "string".
std::string kind_of(const Json& value) {
    return value.is_array() ? fmt::format("a list of {} elements", value.size())
                            : value.type_name();
}

Matrix matrix_of(const Json& eye, const std::string& path, const char* key) {
    const Json& list = part(eye, path, key);
    Matrix matrix{fmt::format("{}.{}", path, key)};
    if (!list.is_array() || list.size() != elements) {
        refuse_command(fmt::format("message: {} is {}, must be 16 numbers, column by column",
                                   matrix.name, kind_of(list)));
    }
    for (std::size_t i = 0; i < elements; ++i) {
        if (!list[i].is_number() || !std::isfinite(list[i].get<double>())) {
            refuse_command(fmt::format("message: {} is {}, must be a finite number",
                                       matrix.name_of(i), list[i].type_name()));
        }
        matrix.values.at(i) = list[i].get<double>();
    }
    return matrix;
}

/// Throws RequestError unless the matrix is a rotation and a translation.
void check_rigid(const Matrix& matrix) {
    constexpr const char* why = "patient_to_eye is a rotation and a translation";
    for (const std::size_t element : {3U, 7U, 11U}) {
        matrix.check_equal(element, 0, why);
    }
    matrix.check_equal(elements - 1, 1, why);
    const glm::dmat3 rotation(matrix.matrix());
    for (int a = 0; a < 3; ++a) {
        for (int b = a; b < 3; ++b) {
            const double product = glm::dot(rotation[a], rotation[b]), wanted = a == b ? 1 : 0;
            if (!(std::abs(product - wanted) <= rotation_error)) {
                refuse_command(fmt::format(
                    "message: {}: columns {} and {} of the rotation have the product {:g}, "
                    "must have {:g}, because a rotation has no scale",
                    matrix.name, a, b, product, wanted));
            }
        }
    }
    if (glm::determinant(rotation) < 0) {
        refuse_command(
            fmt::format("message: {} mirrors the patient: its determinant is {:g}, must "
                        "be 1",
                        matrix.name, glm::determinant(rotation)));
    }
    for (const std::size_t element : {12U, 13U, 14U}) {
        matrix.check_element(element, -max_eye_mm, max_eye_mm);
    }
}

/// Throws RequestError unless the matrix is a perspective as glFrustum() makes it.
void check_perspective(const Matrix& matrix) {
    constexpr const char* why = "projection is an OpenGL perspective";
    for (const std::size_t element : {1U, 2U, 3U, 4U, 6U, 7U, 12U, 13U, 15U}) {
        matrix.check_equal(element, 0, why);
    }
    matrix.check_equal(11, -1, why);
    matrix.check_element(0, min_scale, max_scale);
    matrix.check_element(5, min_scale, max_scale);
    matrix.check_element(8, -max_offset, max_offset);
    matrix.check_element(9, -max_offset, max_offset);
    const double near_mm = matrix.at(14) / (matrix.at(10) - 1);
    const double far_mm = matrix.at(14) / (matrix.at(10) + 1);
    if (!(near_mm >= min_near_mm && far_mm > near_mm && far_mm <= max_eye_mm)) {
        refuse_command(
            fmt::format("message: {} has its near plane at {:g} mm and its far plane at "
                        "{:g} mm, must have {:g} <= near < far <= {:g} mm",
                        matrix.name, near_mm, far_mm, min_near_mm, max_eye_mm));
    }
}

CameraMatrices eye_of(const Json& eyes, const char* side) {
    const std::string path = fmt::format("eyes.{}", side);
    const Json& eye = part(eyes, "eyes", side);
    const Matrix patient_to_eye = matrix_of(eye, path, "patient_to_eye");
    const Matrix projection = matrix_of(eye, path, "projection");
    check_rigid(patient_to_eye);
    check_perspective(projection);
    return {patient_to_eye.matrix(), projection.matrix()};
}

}  // namespace

HeadsetEyes read_headset_eyes(const Json& eyes) {
    if (!eyes.is_object()) {
        refuse_command(fmt::format("message: \"eyes\" is of type {}, must be an object or null",
                                   eyes.type_name()));
    }
    HeadsetEyes read;
    read.pose = whole(part(eyes, "eyes", "pose"), "eyes.pose", 1,
                      std::numeric_limits<std::uint32_t>::max());
    const Json& size = part(eyes, "eyes", "size");
    if (!size.is_array() || size.size() != 2) {
        refuse_command(fmt::format(
            "message: eyes.size is {}, must be a list of width and height",
            size.is_array() ? fmt::format("a list of {}", size.size()) : size.type_name()));
    }
    const auto side = [&](std::size_t axis) {
        return static_cast<int>(
            whole(size[axis], fmt::format("eyes.size[{}]", axis), min_eye_px, max_user_picture_px));
    };
    read.size = {side(0), side(1)};
    read.eyes = {eye_of(eyes, "left"), eye_of(eyes, "right")};
    return read;
}

}  // namespace pxpl5::host::serve
