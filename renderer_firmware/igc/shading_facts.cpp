#include "renderer_firmware/igc/shading_facts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>

#include "ringbus/rules/light_sum.hpp"

namespace pxpl5::renderer {
namespace {

void require(bool holds, const std::string& what) {
    if (!holds) {
        throw std::invalid_argument("shading: " + what);
    }
}

}  // namespace

std::optional<Vector> normalized(Vector v) {
    const double length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
    if (!(length > 1e-6) || !std::isfinite(length)) {
        return std::nullopt;
    }
    return Vector{v.x / length, v.y / length, v.z / length};
}

double brightest_light(const Shading& shading) {
    const std::size_t count = shading.lights.size();
    double most = 0;
    for (std::size_t facing = 0; facing < std::size_t{1} << count; ++facing) {
        Vector sum{0, 0, 0};
        for (std::size_t i = 0; i < count; ++i) {
            const Light& light = shading.lights[i];
            const Vector l = *normalized({light.direction.x, light.direction.y, light.direction.z});
            const double share = (facing >> i & 1U) != 0 ? light.intensity : 0;
            sum = {sum.x + share * l.x, sum.y + share * l.y, sum.z + share * l.z};
        }
        most = std::max(most, std::sqrt(sum.x * sum.x + sum.y * sum.y + sum.z * sum.z));
    }
    return shading.ambient + most;
}

void verify(const Shading& s) {
    require(s.lights.size() <= max_lights,
            fmt::format("{} lights; at most {}", s.lights.size(), max_lights));
    require(s.surfaces.size() <= max_surfaces,
            fmt::format("{} surfaces; at most {}", s.surfaces.size(), max_surfaces));
    require(s.screens.size() <= s.surfaces.size(),
            fmt::format("{} screens of {} surfaces", s.screens.size(), s.surfaces.size()));
    require(s.rims.size() <= s.surfaces.size(),
            fmt::format("{} rims of {} surfaces", s.rims.size(), s.surfaces.size()));
    for (const float rim : s.rims) {
        require(rim >= 0 && rim <= 1, fmt::format("rim {}; must be 0..1", rim));
    }
    require(s.planes <= s.surfaces.size(),
            fmt::format("{} slice planes among {} surfaces", s.planes, s.surfaces.size()));
    for (const Screen& screen : s.screens) {
        require(screen.opacity >= 1 && screen.opacity <= full_opacity,
                fmt::format("opacity {}; must be 1..{}", screen.opacity, full_opacity));
    }
    const Pass pass = s.pass;
    require(
        pass.samples == 1 || pass.samples == few_samples || pass.samples == many_samples,
        fmt::format("{} samples; must be 1, {} or {}", pass.samples, few_samples, many_samples));
    require(pass.sample < pass.samples,
            fmt::format("sample {} of {}, counted from 0", pass.sample, pass.samples));
    require(s.specular_power >= 1 && s.specular_power <= max_specular_power,
            fmt::format("specular power {}; must be 1..{}", s.specular_power, max_specular_power));
    require(s.specular >= 0 && s.specular <= 1,
            fmt::format("specular {}; must be 0..1", s.specular));
    require(s.ambient >= 0, fmt::format("ambient {}; must not be negative", s.ambient));
    double sum = s.ambient;
    for (const Light& light : s.lights) {
        const Light::Direction& d = light.direction;
        require(light.intensity >= 0,
                fmt::format("a light of intensity {}; must not be negative", light.intensity));
        require(normalized({d.x, d.y, d.z}).has_value(),
                fmt::format("a light's direction ({}, {}, {}) has no length", d.x, d.y, d.z));
        sum += light.intensity;
    }
    require(
        sum <= bus::max_light_sum,
        fmt::format("ambient and intensities sum up to {}; at most {}", sum, bus::max_light_sum));
}

}  // namespace pxpl5::renderer
