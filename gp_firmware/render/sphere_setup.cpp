#include "gp_firmware/render/sphere_setup.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace pxpl5::gp {

namespace {

namespace region = isa::region;

/// Smaller spheres are not drawn, because they cover hardly any pixel center.
constexpr double min_radius_px = 1.0 / 64;
/// No picture has slopes and offsets beyond this.
constexpr double max_coefficient = 0x1p32;

/// Around the sphere's center, s = (u, v, t) is the place on the screen minus the center's, t in
/// depth units. A point q (from the center) is q = W H s, with W = center_w / (1 - h s).
struct Frame {
    glm::dmat3 H;
    glm::dvec3 h;
    glm::dvec3 at;      ///< The center on the screen: px, px, depth.
    double w = 0;       ///< W of the center.
    double w_near = 0;  ///< W of the sphere's point nearest to the eye's plane.
};

std::optional<Frame> frame_of(const glm::dvec3& center, double radius, const glm::dmat4& to_grid) {
    const glm::dmat4 rows = glm::transpose(to_grid);
    const glm::dvec4 m = to_grid * glm::dvec4(center, 1.0);
    const glm::dvec3 row_w(rows[3]);
    Frame frame;
    frame.w = m.w;
    frame.w_near = m.w - radius * glm::length(row_w);
    if (!(frame.w_near >= static_cast<double>(w_min))) {
        return std::nullopt;
    }
    frame.at = glm::dvec3(m) / m.w;
    glm::dmat3 g;  // Its columns are the rows of q -> W s.
    for (int k = 0; k < 3; ++k) {
        const double to_px = k < 2 ? 1.0 / subpixels : 1.0;
        g[k] = (glm::dvec3(rows[k]) - row_w * frame.at[k]) * to_px;
        frame.at[k] *= to_px;
    }
    frame.H = glm::inverse(glm::transpose(g));
    frame.h = glm::transpose(frame.H) * row_w;
    return frame;
}

/// The sphere as a quadric s'Ks + 2 h's = 1 of the screen, which follows from |q| = radius.
glm::dmat3 quadric_of(const Frame& frame, double radius) {
    const double scale = (frame.w / radius) * (frame.w / radius);
    return glm::transpose(frame.H) * frame.H * scale - glm::outerProduct(frame.h, frame.h);
}

/// Returns whether all depths of the quadric can be stored.
bool in_depth_range(const glm::dmat3& K, const Frame& frame) {
    const glm::dmat3 inverse = glm::inverse(K);
    const glm::dvec3 middle = -(inverse * frame.h);
    const double reach = std::sqrt((1 - glm::dot(frame.h, middle)) * inverse[2][2]);
    const double z = frame.at.z + middle.z;
    return z - reach >= region::z_margin && z + reach <= double{region::z_far - region::z_margin};
}

/// The discriminant of the quadric's equation for t, over the screen.
std::array<double, 6> discriminant(const glm::dmat3& K, const glm::dvec3& h) {
    const double a = K[2][2], ku = K[0][2], kv = K[1][2];
    return {h.z * h.z + a,         2 * (ku * h.z - a * h.x),    2 * (kv * h.z - a * h.y),
            ku * ku - a * K[0][0], 2 * (ku * kv - a * K[0][1]), kv * kv - a * K[1][1]};
}

/// The place where the form is largest, and the distance of the outline along u and v.
struct Ellipse {
    double u = 0, v = 0, reach_u = 0, reach_v = 0, peak = 0;
};

Ellipse ellipse_of(const std::array<double, 6>& f) {
    const double det = 4 * f[3] * f[5] - f[4] * f[4];
    Ellipse e;
    e.u = (f[4] * f[2] - 2 * f[5] * f[1]) / det;
    e.v = (f[4] * f[1] - 2 * f[3] * f[2]) / det;
    e.peak = f[0] + 0.5 * (f[1] * e.u + f[2] * e.v);
    e.reach_u = std::sqrt(-4 * f[5] * e.peak / det);
    e.reach_v = std::sqrt(-4 * f[3] * e.peak / det);
    return e;
}

/// Returns the pixels whose centers lie between low and high, clamped to first..last.
int first_pixel(double low) {
    return static_cast<int>(std::ceil(std::clamp(low - 0.5, -1.0, double{max_picture_px})));
}
int last_pixel(double high, int size_px) {
    return static_cast<int>(std::floor(std::clamp(high - 0.5, -1.0, size_px - 1.0)));
}

PixelBox box_of(const Ellipse& e, const Frame& frame, const RegionGrid& grid) {
    const double x = frame.at.x + e.u, y = frame.at.y + e.v;
    return {std::max(first_pixel(x - e.reach_u), 0), std::max(first_pixel(y - e.reach_v), 0),
            last_pixel(x + e.reach_u, grid.width_px), last_pixel(y + e.reach_v, grid.height_px)};
}

bool inside_clip_planes(const Sphere& sphere, const Projection& projection) {
    return std::ranges::all_of(projection.clip_planes, [&](const glm::vec4& plane) {
        const glm::dvec3 normal(plane.x, plane.y, plane.z);
        return glm::dot(normal, glm::dvec3(sphere.p_voxel)) + double{plane.w} >=
               double{sphere.radius} * glm::length(normal);
    });
}

/// Depth and normals as planes and multiples of the form's root.
void set_planes(const glm::dmat3& K, const Frame& frame, double radius, double peak,
                const glm::dmat3& to_eye, ScreenSphere& out) {
    const double a = K[2][2];
    const ScreenPlane t{-K[0][2] / a, -K[1][2] / a, -frame.h.z / a};
    out.depth_plane = {t.a, t.b, t.c + frame.at.z};
    out.depth_root = std::sqrt(peak) / a;
    // |H s| is radius / W, so the nearest point defines the unit.
    const glm::dmat3 n = to_eye * frame.H * (region::normal_unit * frame.w_near / radius);
    for (int k = 0; k < 3; ++k) {
        const auto at = static_cast<std::size_t>(k);
        out.normal_plane[at] = {n[0][k] + n[2][k] * t.a, n[1][k] + n[2][k] * t.b, n[2][k] * t.c};
        out.normal_root[at] = n[2][k] * out.depth_root;
    }
}

bool drawable(const ScreenSphere& s) {
    const auto small = [](double value) { return std::abs(value) < max_coefficient; };
    const auto flat = [&](const ScreenPlane& p) { return small(p.a) && small(p.b) && small(p.c); };
    return std::ranges::all_of(s.form, small) && flat(s.depth_plane) &&
           std::ranges::all_of(s.normal_plane, flat) && s.depth_root < double{region::z_far};
}

}  // namespace

std::optional<ScreenSphere> screen_sphere(const Sphere& sphere, const Projection& projection,
                                          const RegionGrid& grid) {
    const auto radius = static_cast<double>(sphere.radius);
    const auto frame = frame_of(glm::dvec3(sphere.p_voxel), radius, projection.voxel_to_grid_exact);
    if (!frame || !inside_clip_planes(sphere, projection)) {
        return std::nullopt;
    }
    const glm::dmat3 K = quadric_of(*frame, radius);
    ScreenSphere out;
    out.form = discriminant(K, frame->h);
    const Ellipse ellipse = ellipse_of(out.form);
    if (!(ellipse.reach_u >= min_radius_px && ellipse.reach_v >= min_radius_px) ||
        !in_depth_range(K, *frame)) {
        return std::nullopt;
    }
    out.box = box_of(ellipse, *frame, grid);
    if (out.box.empty()) {
        return std::nullopt;
    }
    out.x_px = frame->at.x;
    out.y_px = frame->at.y;
    for (double& f : out.form) {
        f /= ellipse.peak;
    }
    set_planes(K, *frame, radius, ellipse.peak, projection.patient_to_eye, out);
    return drawable(out) ? std::optional(out) : std::nullopt;
}

}  // namespace pxpl5::gp
