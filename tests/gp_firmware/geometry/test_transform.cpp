#include <doctest/doctest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>

#include "gp_firmware/geometry/transform.hpp"

using namespace pxpl5::gp;
namespace region = pxpl5::isa::region;

namespace {

/// A perspective camera about 500 mm before a volume of 128^3 voxels of 1 x 1.2 x 2 mm.
Camera camera(double turn_rad, int width, int height) {
    Camera c;
    c.width_px = width;
    c.height_px = height;
    c.voxel_to_patient =
        glm::scale(glm::translate(glm::dmat4(1.0), {-64, -77, -128}), glm::dvec3(1, 1.2, 2));
    const glm::dmat4 patient_to_eye = glm::rotate(glm::translate(glm::dmat4(1.0), {3, -5, -500}),
                                                  turn_rad, glm::normalize(glm::dvec3(1, 2, 3)));
    c.voxel_to_eye = patient_to_eye * c.voxel_to_patient;
    c.projection = glm::perspective(0.7, static_cast<double>(width) / height, 200.0, 800.0);
    return c;
}

Vertex vertex(glm::vec3 p, glm::dvec3 n) {
    const glm::dvec3 u = glm::normalize(n) * 32767.0;
    return {
        p,
        {static_cast<std::int16_t>(std::lround(u.x)), static_cast<std::int16_t>(std::lround(u.y)),
         static_cast<std::int16_t>(std::lround(u.z))},
        0};
}

ScreenVertex transformed(const Vertex& v, const Camera& c) {
    return pxpl5::gp::transformed({&v, 1}, prepare(c)).front();
}

/// The formula of transform(), in floats.
ScreenVertex one_by_one(const Vertex& vertex, const Projection& m) {
    ScreenVertex out;
    const glm::vec3& p = vertex.p_voxel;
    const auto row = [&](std::size_t r) {
        const auto& g = m.voxel_to_grid;
        return ((g[0][r] * p.x + g[1][r] * p.y) + g[2][r] * p.z) + g[3][r];
    };
    const auto held = [](float v, float low, float high) {
        v = v > low ? v : low;
        return v < high ? v : high;
    };
    constexpr float guard = 16384 * 16, z_low = 1024, z_high = (1 << 24) - 1 - 1024;
    const float w = row(3), x = row(0) / w, y = row(1) / w, z = row(2) / w;
    const auto beyond = [&out](float v, float low, float high, std::uint32_t below,
                               std::uint32_t above) {
        out.outside |= (v >= low ? 0 : below) | (v <= high ? 0 : above);
    };
    beyond(x, -guard, guard, outside_left, outside_right);
    beyond(y, -guard, guard, outside_top, outside_bottom);
    beyond(z, z_low, z_high, outside_near, outside_far);
    if (!(w >= w_min)) {
        out.outside = outside_w;
    }
    out.x = static_cast<int>(held(x, -guard, guard) + (guard + 0.5F)) - 16384 * 16;
    out.y = static_cast<int>(held(y, -guard, guard) + (guard + 0.5F)) - 16384 * 16;
    out.z = static_cast<int>(held(z, z_low, z_high));
    for (std::size_t k = 0; k < m.clip_planes.size(); ++k) {
        const glm::vec4& plane = m.clip_planes[k];
        const float d = ((plane.x * p.x + plane.y * p.y) + plane.z * p.z) + plane.w;
        out.outside |= d >= 0 ? 0 : outside_user << k;
    }
    const auto turned = [&](std::size_t k) {
        const auto& n = m.normal_to_eye;
        const float sum = (n[0][k] * static_cast<float>(vertex.normal[0]) +
                           n[1][k] * static_cast<float>(vertex.normal[1])) +
                          n[2][k] * static_cast<float>(vertex.normal[2]);
        return static_cast<int>(held(sum, -510, 510) + 1020.5F) - 1020;
    };
    out.nx = turned(0);
    out.ny = turned(1);
    out.nz = turned(2);
    return out;
}

std::string refusal(const Camera& c) {
    try {
        prepare(c);
    } catch (const std::invalid_argument& e) {
        return e.what();
    }
    return {};
}

}  // namespace

TEST_SUITE("gp/transform") {
    TEST_CASE("positions and normals are those of the matrices in doubles, rounded") {
        std::mt19937 engine(5);
        std::uniform_real_distribution<float> voxel(0, 127);
        std::uniform_real_distribution<double> component(-1, 1), angle(-3, 3);
        for (const int width : {64, 512, 4096}) {
            for (int i = 0; i < 500; ++i) {
                const Camera c = camera(angle(engine), width, width * 3 / 4);
                const Vertex v = vertex({voxel(engine), voxel(engine), voxel(engine)},
                                        {component(engine), component(engine), component(engine)});
                const ScreenVertex out = transformed(v, c);

                const glm::dvec4 clip =
                    c.projection * (c.voxel_to_eye * glm::dvec4(glm::dvec3(v.p_voxel), 1));
                const glm::dvec3 ndc = glm::dvec3(clip) / clip.w;
                const double slack = 0.55 + width / 4096.0 * 0.1;
                CHECK(std::abs(out.x - (ndc.x + 1) * 8 * c.width_px) < slack);
                CHECK(std::abs(out.y - (1 - ndc.y) * 8 * c.height_px) < slack);
                const double depth =
                    region::z_margin + (ndc.z + 1) / 2 * (region::z_far - 2.0 * region::z_margin);
                CHECK(std::abs(out.z - depth) < 30);  // 2^24 steps; a float has as many.
                CHECK(out.outside == 0);

                const glm::dmat3 turn =
                    glm::dmat3(c.voxel_to_eye) * glm::inverse(glm::dmat3(c.voxel_to_patient));
                const glm::dvec3 n = turn * glm::dvec3(v.normal[0], v.normal[1], v.normal[2]) *
                                     (region::normal_unit / 32767.0);
                CHECK(std::abs(out.nx - n.x) < 0.51);
                CHECK(std::abs(out.ny - n.y) < 0.51);
                CHECK(std::abs(out.nz - n.z) < 0.51);
            }
        }
    }

    TEST_CASE("every target gives the bits of one fixed order of operations, one by one") {
        std::mt19937 engine(6);
        // Also what lies beside, behind and far beyond.
        std::uniform_real_distribution<float> voxel(-400, 500), far(-1e30F, 1e30F);
        std::uniform_int_distribution<int> component(-32767, 32767);
        Camera c = camera(0.7, 512, 384);
        c.clip_planes = {{1, 0.5, 0.2, -40}, {-1, 0.2, 0, 90}};
        for (const std::size_t count : {0, 1, 3, 4, 7, 8, 15, 16, 17, 33, 5000}) {
            std::vector<Vertex> vertices;
            for (std::size_t i = 0; i < count; ++i) {
                const auto n = [&] { return static_cast<std::int16_t>(component(engine)); };
                const auto p = [&] { return i % 50 == 49 ? far(engine) : voxel(engine); };
                vertices.push_back({{p(), p(), p()}, {n(), n(), n()}, 0});
            }
            const Projection projection = prepare(c);
            for (const auto target : pxpl5::isa::available_targets()) {
                INFO(std::string(pxpl5::enum_name(target)), ", ", count);
                std::vector<GridVertex> grid(count);
                std::vector<std::uint32_t> outside(count);
                const std::uint32_t any = transform(vertices, projection, grid, outside, target);
                int wrong = 0;
                std::uint32_t all = 0;
                for (std::size_t i = 0; i < count; ++i) {
                    const ScreenVertex v = one_by_one(vertices[i], projection);
                    const ScreenVertex got = screen_vertex(grid[i], outside[i]);
                    all |= v.outside;
                    wrong +=
                        got.outside != v.outside || got.nx != v.nx || got.ny != v.ny ||
                                got.nz != v.nz ||
                                (v.outside == 0 && (got.x != v.x || got.y != v.y || got.z != v.z))
                            ? 1
                            : 0;
                }
                CHECK(wrong == 0);
                CHECK(any == all);
            }
        }
    }

    TEST_CASE("y runs down: what is up to the eye has the smaller y") {
        Camera c;
        c.width_px = c.height_px = 100;
        c.projection = glm::ortho(-1.0, 1.0, -1.0, 1.0, -1.0, 1.0);
        CHECK(transformed(vertex({0, 0.5, 0}, {0, 0, 1}), c).y == 400);
        CHECK(transformed(vertex({0, -0.5, 0}, {0, 0, 1}), c).y == 1200);
        CHECK(transformed(vertex({0.5, 0, 0}, {0, 0, 1}), c).x == 1200);
    }

    TEST_CASE("normals do not shear with the voxels' shape") {
        // A normal along patient x stays along eye x under an unturned camera, whatever the
        // spacing.
        Camera c = camera(0, 512, 512);
        const ScreenVertex out = transformed(vertex({64, 64, 64}, {1, 0, 0}), c);
        CHECK(out.nx == region::normal_unit);
        CHECK(out.ny == 0);
        CHECK(out.nz == 0);
    }

    TEST_CASE("each side of the view has its own bit") {
        Camera c;
        c.width_px = c.height_px = 16;
        c.projection = glm::ortho(-1.0, 1.0, -1.0, 1.0, -1.0, 1.0);
        const auto outside = [&](glm::vec3 p) {
            return transformed(vertex(p, {0, 0, 1}), c).outside;
        };
        CHECK(outside({0, 0, 0}) == 0);
        // Off the picture but within the guard band.
        CHECK(outside({100, -100, 0}) == 0);
        // 8 px to the unit: 16384 px are 2048 units, and one half.
        CHECK(outside({-3000, 0, 0}) == outside_left);
        CHECK(outside({3000, 0, 0}) == outside_right);
        CHECK(outside({0, 3000, 0}) == outside_top);
        CHECK(outside({0, -3000, 0}) == outside_bottom);
        CHECK(outside({0, 0, 1.5F}) == outside_near);
        CHECK(outside({0, 0, -1.5F}) == outside_far);
        CHECK(outside({-1e30F, 1e30F, 1e30F}) == (outside_left | outside_top | outside_near));
        c.clip_planes = {{1, 0, 0, -0.25}, {0, 1, 0, 0}};
        CHECK(outside({0.25F, 0, 0}) == 0);
        CHECK(outside({0.2F, -0.1F, 0}) == (outside_user | outside_user << 1));
    }

    TEST_CASE("what is at or behind the eye has no position") {
        const Camera c = camera(0, 512, 512);
        Camera inside = c;
        inside.voxel_to_eye = c.voxel_to_patient;  // The eye is in the volume's middle.
        const ScreenVertex behind = transformed(vertex({64, 64, 100}, {0, 0, 1}), inside);
        CHECK(behind.outside == outside_w);
        inside.voxel_to_eye[3] = glm::dvec4(0, 0, 0, 1);
        CHECK(transformed(vertex({0, 0, 0}, {0, 0, 1}), inside).outside == outside_w);
    }

    TEST_CASE("an unusable camera is refused by name") {
        CHECK(refusal(camera(0, 0, 512)).find("0 x 512") != std::string::npos);
        CHECK(refusal(camera(0, 512, 8193)).find("8193") != std::string::npos);
        Camera c = camera(0, 512, 512);
        c.projection[2][1] = std::numeric_limits<double>::quiet_NaN();
        CHECK(refusal(c).find("projection[2][1]") != std::string::npos);
        c = camera(0, 512, 512);
        c.voxel_to_eye[0] *= 2.0;
        CHECK(refusal(c).find("rigid") != std::string::npos);
        c = camera(0, 512, 512);
        c.voxel_to_patient[0] = glm::dvec4(0);
        CHECK(refusal(c).find("determinant 0") != std::string::npos);
        c = camera(0, 512, 512);
        c.clip_planes.assign(17, {1, 0, 0, 0});
        CHECK(refusal(c).find("17 clip planes; 16 at most") != std::string::npos);
        c.clip_planes.assign(1, {1, 0, 0, std::numeric_limits<double>::infinity()});
        CHECK(refusal(c).find("not finite") != std::string::npos);
        CHECK(refusal(camera(0, 8192, 1)).empty());
    }
}
