// Points that rays of a view meet on phantoms whose shape is known, computed without a machine.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "host/scene/camera.hpp"
#include "host/scene/scene.hpp"

namespace pxpl5::test {

/// A straight line from the viewer through the middle of a pixel; patient mm, unit direction.
struct Ray {
    glm::dvec3 from, along;
    glm::dvec3 at(double t) const { return from + t * along; }
};

inline Ray ray_of(const host::CameraMatrices& camera, host::Size size, int x, int y) {
    const glm::dmat4 to_patient = glm::inverse(camera.projection * camera.patient_to_eye);
    const glm::dvec4 far = to_patient * glm::dvec4(2 * (x + 0.5) / size.width - 1,
                                                   1 - 2 * (y + 0.5) / size.height, 1, 1);
    const glm::dvec3 eye(glm::inverse(camera.patient_to_eye) * glm::dvec4(0, 0, 0, 1));
    return {eye, glm::normalize(glm::dvec3(far) / far.w - eye)};
}

/// Nearer to an edge, a cut or a silhouette, either side may be right.
inline constexpr double doubt_mm = 1.5, doubt_cosine = 0.15;

/// Points where a ray meets a surface, nearest first, after the clip planes.
struct Met {
    std::vector<glm::dvec3> points;
    bool is_sure = true;  ///< Every point is there, and no other, whatever is rounded.
};

inline void add_point(const glm::dvec3& p, std::span<const host::SceneClip> clips, Met& met) {
    bool is_kept = true;
    for (const host::SceneClip& clip : clips) {
        const double side_mm = glm::dot(clip.plane, glm::dvec4(p, 1));
        met.is_sure = met.is_sure && std::abs(side_mm) > doubt_mm;
        is_kept = is_kept && side_mm > 0;
    }
    if (is_kept) {
        met.points.push_back(p);
    }
}

inline const glm::dvec3 sphere_center_mm(0.3, -0.7, 0.45);

/// The sphere of phantom:sphere and those around its center.
inline Met meet_sphere(const Ray& ray, double radius_mm, std::span<const host::SceneClip> clips) {
    const double nearest = glm::dot(sphere_center_mm - ray.from, ray.along);
    const double off_mm = glm::distance(ray.at(nearest), sphere_center_mm);
    Met met;
    if (off_mm < radius_mm) {
        const double half = std::sqrt(radius_mm * radius_mm - off_mm * off_mm);
        add_point(ray.at(nearest - half), clips, met);
        add_point(ray.at(nearest + half), clips, met);
        met.is_sure = met.is_sure && half > doubt_cosine * radius_mm;
    }
    met.is_sure = met.is_sure && std::abs(off_mm - radius_mm) > doubt_mm / 4;
    return met;
}

struct Box {
    glm::dvec3 middle, half;

    double distance_mm(const glm::dvec3& p) const {
        const glm::dvec3 d = glm::abs(p - middle) - half;
        return glm::length(glm::max(d, 0.0)) + std::min(std::max({d.x, d.y, d.z}), 0.0);
    }
    /// Where the ray enters and leaves.
    std::optional<std::array<double, 2>> span(const Ray& ray) const {
        double in = -1e9, out = 1e9;
        for (int axis = 0; axis < 3; ++axis) {
            const double a = (middle[axis] - half[axis] - ray.from[axis]) / ray.along[axis];
            const double b = (middle[axis] + half[axis] - ray.from[axis]) / ray.along[axis];
            in = std::max(in, std::min(a, b));
            out = std::min(out, std::max(a, b));
        }
        return in < out ? std::optional(std::array{in, out}) : std::nullopt;
    }
};

/// The block of phantom:letters, and boxes that hold its letters with their feet.
inline const std::array<Box, 2> block = {
    {{{-22, 0, 0}, {22, 20, 46}}, {{0, 0, -24}, {44, 20, 22}}}};
inline const std::array<Box, 6> letter_boxes = {{{{-22, -20, 16}, {17, 5, 23}},
                                                 {{-22, 20, 16}, {17, 5, 23}},
                                                 {{-44, 0, 4}, {5, 17, 23}},
                                                 {{44, 0, -24}, {5, 15, 20}},
                                                 {{-22, 0, 46}, {13, 17, 5}},
                                                 {{0, 0, -46}, {13, 17, 5}}}};

inline double block_distance_mm(const glm::dvec3& p) {
    return std::min(block[0].distance_mm(p), block[1].distance_mm(p));
}

/// Whether the block's side at p is flat around it.
inline bool is_flat(const glm::dvec3& p) {
    for (int normal = 0; normal < 3; ++normal) {
        double most_mm = 0;
        for (int axis = 0; axis < 3; ++axis) {
            for (const double by_mm : {-2.5, 2.5}) {
                glm::dvec3 beside = p;
                beside[axis] += axis == normal ? 0 : by_mm;
                most_mm = std::max(most_mm, std::abs(block_distance_mm(beside)));
            }
        }
        if (most_mm < 1e-6) {
            return true;
        }
    }
    return false;
}

/// phantom:letters where it has no letter.
inline Met meet_block(const Ray& ray, std::span<const host::SceneClip> clips) {
    Met met;
    for (const Box& letter : letter_boxes) {
        met.is_sure = met.is_sure && !letter.span(ray);
    }
    std::vector<double> ends;
    for (const Box& box : block) {
        if (const auto span = box.span(ray)) {
            ends.insert(ends.end(), span->begin(), span->end());
        }
    }
    std::ranges::sort(ends);
    double last = -1e9;
    for (const double t : ends) {
        const bool is_new = t - std::exchange(last, t) > 1e-6;  // Sides of both boxes may be one.
        if (is_new && block_distance_mm(ray.at(t)) > -1e-9) {   // Else inside of the other box.
            met.is_sure = met.is_sure && is_flat(ray.at(t));
            add_point(ray.at(t), clips, met);
        }
    }
    return met;
}

}  // namespace pxpl5::test
