#include "host/scene/stereo.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/mat3x3.hpp>
#include <utility>

namespace pxpl5::host {

namespace {

constexpr std::array<std::pair<StereoMode, std::string_view>, 5> words{
    {{StereoMode::off, "off"},
     {StereoMode::anaglyph, "anaglyph"},
     {StereoMode::side_by_side, "sbs"},
     {StereoMode::crossed, "cross"},
     {StereoMode::rows, "rows"}}};

constexpr double usual_separation = 0.035;  ///< Share of the camera's distance at zoom 1.

/// E. Dubois, "A projection method to generate anaglyph stereo images", ICASSP 2001, for red and
/// cyan filters. Linear light in, linear light out; each line is one output.
const glm::dmat3 left_filter = glm::transpose(glm::dmat3(0.4561, 0.500484, 0.176381,          //
                                                         -0.0400822, -0.0378246, -0.0157589,  //
                                                         -0.0152161, -0.0205971, -0.00546856));
const glm::dmat3 right_filter = glm::transpose(glm::dmat3(-0.0434706, -0.0879388, -0.00155529,  //
                                                          0.378476, 0.73364, -0.0184503,        //
                                                          -0.0721527, -0.112961, 1.2264));

/// IEC 61966-2-1: linear light of an sRGB value, both 0..1.
double to_linear(double value) {
    constexpr double knee = 0.04045;
    return value <= knee ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

double to_srgb(double linear) {
    constexpr double knee = 0.0031308;
    return linear <= knee ? linear * 12.92 : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

constexpr int byte_max = 255;

std::array<double, byte_max + 1> linear_table() {
    std::array<double, byte_max + 1> table{};
    for (int value = 0; value <= byte_max; ++value) {
        table.at(static_cast<std::size_t>(value)) = to_linear(value / double{byte_max});
    }
    return table;
}

/// sRGB bytes of linear light in steps that are finer than those of dark bytes.
constexpr int srgb_steps = 1 << 14;
std::vector<std::uint8_t> srgb_table() {
    std::vector<std::uint8_t> table;
    for (int step = 0; step <= srgb_steps; ++step) {
        table.push_back(
            static_cast<std::uint8_t>(std::lround(byte_max * to_srgb(step / double{srgb_steps}))));
    }
    return table;
}

glm::dvec3 light_of(std::uint32_t rgba) {
    static const std::array<double, byte_max + 1> table = linear_table();
    return {table[rgba & 0xff], table[rgba >> 8 & 0xff], table[rgba >> 16 & 0xff]};
}

std::uint32_t rgba_of(const glm::dvec3& light) {
    static const std::vector<std::uint8_t> table = srgb_table();
    std::uint32_t rgba = 0xff00'0000U;
    for (int channel = 0; channel < 3; ++channel) {
        const double held = std::clamp(light[channel], 0.0, 1.0);
        rgba |= std::uint32_t{table[static_cast<std::size_t>(std::lround(held * srgb_steps))]}
                << (8 * channel);
    }
    return rgba;
}

/// Copies rows of `from` into a picture of `row_px` pixels a row, from column `at` on.
void paste(std::span<const std::uint32_t> from, std::size_t from_px, std::size_t at,
           std::size_t row_px, std::vector<std::uint32_t>& into) {
    for (std::size_t y = 0; y * from_px < from.size(); ++y) {
        std::ranges::copy(from.subspan(y * from_px, from_px),
                          into.begin() + static_cast<std::ptrdiff_t>(y * row_px + at));
    }
}

}  // namespace

std::string_view stereo_word(StereoMode mode) {
    return words.at(static_cast<std::size_t>(mode)).second;
}

std::optional<StereoMode> find_stereo(std::string_view word) {
    for (const auto& [mode, name] : words) {
        if (name == word) {
            return mode;
        }
    }
    return std::nullopt;
}

EyePlaces eye_places(const Stereo& stereo, const Camera& camera, const Subject& subject) {
    const double distance_mm = camera_distance_mm(subject);
    return {stereo.separation_mm > 0 ? stereo.separation_mm
                                     : usual_separation * distance_mm / camera.zoom,
            stereo.convergence_mm > 0 ? stereo.convergence_mm : distance_mm};
}

std::vector<CameraMatrices> eye_matrices(const CameraMatrices& middle, const EyePlaces& places) {
    std::vector<CameraMatrices> eyes;
    for (const double side : {-0.5, 0.5}) {
        const double shift_mm = side * places.separation_mm;
        CameraMatrices& eye = eyes.emplace_back(middle);
        eye.patient_to_eye =
            glm::translate(glm::dmat4(1.0), glm::dvec3(-shift_mm, 0, 0)) * middle.patient_to_eye;
        // Moves the frustum back, so that both eyes see the plane of convergence alike.
        eye.projection[2][0] -= middle.projection[0][0] * shift_mm / places.convergence_mm;
    }
    return eyes;
}

Size composed_size(Size eye, StereoMode mode) {
    const bool is_wide = mode == StereoMode::side_by_side || mode == StereoMode::crossed;
    return {is_wide ? 2 * eye.width : eye.width, eye.height};
}

std::vector<std::uint32_t> composed(std::span<const std::uint32_t> pair, Size eye,
                                    StereoMode mode) {
    const auto width = static_cast<std::size_t>(eye.width);
    const std::size_t pixels = pair.size() / 2;
    assert(mode != StereoMode::off);
    assert(pixels == width * static_cast<std::size_t>(eye.height));
    const std::span<const std::uint32_t> left = pair.first(pixels), right = pair.subspan(pixels);
    if (mode == StereoMode::side_by_side || mode == StereoMode::crossed) {
        std::vector<std::uint32_t> picture(2 * pixels);
        const bool is_crossed = mode == StereoMode::crossed;
        paste(is_crossed ? right : left, width, 0, 2 * width, picture);
        paste(is_crossed ? left : right, width, width, 2 * width, picture);
        return picture;
    }
    std::vector<std::uint32_t> picture(left.begin(), left.end());
    if (mode == StereoMode::anaglyph) {
        std::ranges::transform(left, right, picture.begin(),
                               [](std::uint32_t seen_left, std::uint32_t seen_right) {
                                   return rgba_of(left_filter * light_of(seen_left) +
                                                  right_filter * light_of(seen_right));
                               });
        return picture;
    }
    for (std::size_t y = 1; y < static_cast<std::size_t>(eye.height); y += 2) {
        std::ranges::copy(right.subspan(y * width, width),
                          picture.begin() + static_cast<std::ptrdiff_t>(y * width));
    }
    return picture;
}

EyePixel eye_pixel(int x, int y, Size eye, StereoMode mode) {
    switch (mode) {
        case StereoMode::side_by_side:
            return {x / eye.width, x % eye.width, y};
        case StereoMode::crossed:
            return {1 - x / eye.width, x % eye.width, y};
        case StereoMode::rows:
            return {y & 1, x, y};
        default:
            return {0, x, y};
    }
}

}  // namespace pxpl5::host
