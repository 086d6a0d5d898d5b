// Verdicts on triangles that no recorded stream holds: from the GP's stages, run again.
#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "gp_firmware/geometry/clip.hpp"
#include "gp_firmware/render/draw_slab.hpp"
#include "gp_firmware/render/plane_setup.hpp"
#include "host/inspect/why/why_not.hpp"

namespace pxpl5::host::inspect {

namespace {

constexpr std::uint32_t all_planes = ~std::uint32_t{0};

TriangleVerdict verdict_on(const TriangleName& name, Verdict verdict, std::string reason = {}) {
    TriangleVerdict result;
    result.verdict = verdict;
    result.surface = name.surface;
    result.name = name;
    result.reason = std::move(reason);
    return result;
}

/// A triangle of the slab: its corners as the mesh and the screen have them.
struct Corners {
    std::array<const gp::Vertex*, 3> mesh{};
    std::array<const gp::ScreenVertex*, 3> screen{};

    std::uint32_t outside_all() const {
        return screen[0]->outside & screen[1]->outside & screen[2]->outside;
    }
    std::uint32_t outside_any() const {
        return screen[0]->outside | screen[1]->outside | screen[2]->outside;
    }
    std::array<glm::dvec3, 3> points() const {
        return {glm::dvec3(mesh[0]->p_voxel), glm::dvec3(mesh[1]->p_voxel),
                glm::dvec3(mesh[2]->p_voxel)};
    }
};

Corners corners_of(const ReplayedSlab& slab, std::size_t triangle) {
    Corners corners;
    for (std::size_t n = 0; n < 3; ++n) {
        const std::uint32_t vertex = slab.mesh.indices[3 * triangle + n];
        corners.mesh[n] = &slab.mesh.vertices[vertex];
        corners.screen[n] = &slab.screen[vertex];
    }
    return corners;
}

/// The mesh's number of the cell's triangle; nothing if the cell has no such triangle.
std::optional<std::size_t> find_triangle(const gp::SlabMesh& mesh, const TriangleName& name) {
    for (std::size_t n = 0; n < mesh.origins.size(); ++n) {
        const gp::Origin& o = mesh.origins[n];
        if (o.i == name.i && o.j == name.j && o.triangle == name.triangle) {
            return n;
        }
    }
    return std::nullopt;
}

/// "the near plane", "clip plane 0 (1, 0, 0, -20)", of the lowest bit.
std::string plane_text(const gp::Camera& camera, std::uint32_t bits) {
    const std::uint32_t bit = bits & (~bits + 1);
    switch (bit) {
        case gp::outside_near:
            return "the near plane";
        case gp::outside_far:
            return "the far plane";
        case gp::outside_w:
            return "the eye's plane";
        case gp::outside_left:
        case gp::outside_right:
        case gp::outside_top:
        case gp::outside_bottom:
            return fmt::format("the guard band, {} pixels from the picture's corner", gp::guard_px);
        default:
            break;
    }
    const int index = std::countr_zero(bit / gp::outside_user);
    const glm::dvec4& p = camera.clip_planes.at(static_cast<std::size_t>(index));
    return fmt::format("clip plane {} ({:g}, {:g}, {:g}, {:g})", index, p.x, p.y, p.z, p.w);
}

TriangleVerdict clipped(const TriangleName& name, const gp::Camera& camera, std::uint32_t bits) {
    TriangleVerdict verdict = verdict_on(name, Verdict::clipped);
    verdict.plane = plane_text(camera, bits);
    return verdict;
}

/// Whether the whole triangle, cut by no plane, lies on the ray through the center of the pixel.
bool on_ray(const PixelInquiry& inquiry, const gp::Projection& projection, const Corners& corners) {
    const glm::dvec3 w = ray_weights(projection, corners.points(), inquiry.x, inquiry.y_in_view());
    return w.x >= 0 && w.y >= 0 && w.z >= 0;
}

/// The planes that cut away the point where the pixel's ray meets the triangle.
std::uint32_t cut_on_ray(const PixelInquiry& inquiry, const gp::Projection& projection,
                         const Corners& corners) {
    const auto points = corners.points();
    const glm::dvec3 w = ray_weights(projection, points, inquiry.x, inquiry.y_in_view());
    gp::Vertex hit;
    hit.p_voxel = glm::vec3(w.x * points[0] + w.y * points[1] + w.z * points[2]);
    hit.normal = corners.mesh[0]->normal;
    return gp::transformed(std::span(&hit, 1), projection).front().outside;
}

/// Why a triangle with all corners in view is not emitted.
std::optional<Verdict> culled(const Corners& corners, const ShownSurface& surface) {
    const auto& [a, b, c] = corners.screen;
    const std::int64_t det = gp::determinant(*a, *b, *c);
    if (det == 0) {
        return Verdict::no_area;
    }
    if (det > 0 && surface.cull_back) {
        return Verdict::back_face;
    }
    return std::nullopt;
}

/// Whether the screen's triangle, of either orientation, covers the center of the pixel.
bool covers(const PixelInquiry& inquiry, const Corners& corners) {
    const auto& [a, b, c] = corners.screen;
    const bool clockwise = gp::determinant(*a, *b, *c) > 0;
    const auto edges = gp::edges_of(*a, clockwise ? *b : *c, clockwise ? *c : *b);
    return std::ranges::all_of(edges, [&](const gp::Edge& e) {
        return e.a * inquiry.x + e.b * inquiry.y_in_view() + e.c >= 0;
    });
}

/// Whether the recorded streams hold a word of the slab.
bool anything_sent(const PixelInquiry& inquiry, std::uint32_t surface, int k) {
    for (const auto& [number, region] : inquiry.frame.regions) {
        for (const renderer::RegionPlan::Part& part : region.plan.parts) {
            if (part.kind == PartKind::segment && part.segment.surface == surface &&
                part.segment.slab == static_cast<std::uint32_t>(k)) {
                return true;
            }
        }
    }
    return false;
}

/// Whether what the stages give for the slab may be believed; if not, the verdict to give instead.
std::optional<TriangleVerdict> distrust(PixelInquiry& inquiry, const TriangleName& name) {
    if (!inquiry.frame.missing.empty()) {
        return verdict_on(name, Verdict::unknown, inquiry.frame.missing.front());
    }
    const std::string difference = inquiry.replayed->difference(name.surface, name.k);
    if (difference.empty()) {
        return std::nullopt;
    }
    if (!anything_sent(inquiry, name.surface, name.k)) {
        const auto set = static_cast<std::uint32_t>(name.k) /
                         static_cast<std::uint32_t>(inquiry.volume.shape().slabs_per_set);
        const std::uint32_t gp = set % inquiry.run.gp_count();
        return verdict_on(name, Verdict::not_sent,
                          fmt::format("gp-{} sent nothing of slab {}", gp, name.k));
    }
    return verdict_on(name, Verdict::unknown,
                      difference + "; so the stages do not show the work of this GP");
}

/// The verdict on a triangle in a slab that the frame omits.
TriangleVerdict not_chosen(const PixelInquiry& inquiry, const TriangleName& name) {
    const bool in_gaps = inquiry.surfaces[name.surface].slabs == SlabChoice::in_gaps;
    return verdict_on(
        name, Verdict::not_sent,
        fmt::format("the frame draws this surface {} gaps between slices only, and "
                    "slab {} is {} one",
                    in_gaps ? "in" : "outside of", name.k, in_gaps ? "not in" : "in"));
}

std::optional<TriangleVerdict> missing_data(PixelInquiry& inquiry, const TriangleName& name) {
    const std::string missing = inquiry.replayed ? inquiry.replayed->missing(name.surface, name.k)
                                                 : "no trace holds the volume's header";
    if (missing.empty()) {
        return std::nullopt;
    }
    return verdict_on(name, Verdict::unknown, missing);
}

/// A triangle of the slab that would cover the pixel, had it not been culled or clipped.
std::optional<TriangleVerdict> removed_from_ray(PixelInquiry& inquiry, const ReplayedSlab& slab,
                                                std::uint32_t surface, int k) {
    const gp::Projection& projection = inquiry.replayed->projection(inquiry.place.view);
    const gp::Camera& camera = inquiry.replayed->camera(inquiry.place.view);
    for (std::size_t n = 0; n < slab.mesh.origins.size(); ++n) {
        const Corners corners = corners_of(slab, n);
        const gp::Origin& o = slab.mesh.origins[n];
        const TriangleName name{surface, o.i, o.j, k, o.triangle};
        if (gp::is_hidden(inquiry.replayed->hidden(surface, k), n)) {
            if (on_ray(inquiry, projection, corners)) {
                return verdict_on(name, Verdict::masked);
            }
        } else if (corners.outside_any() != 0) {
            const std::uint32_t cut =
                on_ray(inquiry, projection, corners) ? cut_on_ray(inquiry, projection, corners) : 0;
            if (cut != 0) {
                return clipped(name, camera, cut);
            }
        } else if (culled(corners, inquiry.surfaces[surface]) == Verdict::back_face &&
                   covers(inquiry, corners)) {
            return verdict_on(name, Verdict::back_face);
        }
    }
    return std::nullopt;
}

}  // namespace

CellCount triangles_of_cell(PixelInquiry& inquiry, const TriangleName& first) {
    CellCount count;
    count.verdict = missing_data(inquiry, first);
    if (count.verdict) {
        return count;
    }
    const ReplayedCell cell = inquiry.replayed->cell(first.surface, first.i, first.j, first.k);
    if (!cell.crossed()) {
        count.verdict = verdict_on(first, Verdict::not_crossed);
        count.verdict->cell = cell;
        return count;
    }
    const gp::SlabMesh& mesh =
        inquiry.replayed->slab(first.surface, first.k, inquiry.place.view).mesh;
    count.triangles = static_cast<int>(std::ranges::count_if(
        mesh.origins, [&](const gp::Origin& o) { return o.i == first.i && o.j == first.j; }));
    return count;
}

std::optional<TriangleVerdict> verdict_of_stages(PixelInquiry& inquiry, const TriangleName& name,
                                                 bool emitted) {
    auto doubt = missing_data(inquiry, name);
    if (!doubt) {
        doubt = distrust(inquiry, name);
    }
    if (doubt) {
        return emitted ? std::nullopt : doubt;
    }
    ReplayedGp& again = *inquiry.replayed;
    if (!again.draws(name.surface, name.k)) {
        return not_chosen(inquiry, name);
    }
    const int view = inquiry.place.view;
    const ReplayedSlab& slab = again.slab(name.surface, name.k, view);
    const std::size_t number = find_triangle(slab.mesh, name).value();
    if (gp::is_hidden(again.hidden(name.surface, name.k), number)) {
        return verdict_on(name, Verdict::masked);
    }
    const Corners corners = corners_of(slab, number);
    if (corners.outside_all() != 0) {
        return clipped(name, again.camera(view), corners.outside_all());
    }
    if (corners.outside_any() != 0) {
        const std::uint32_t cut = on_ray(inquiry, again.projection(view), corners)
                                      ? cut_on_ray(inquiry, again.projection(view), corners)
                                      : 0;
        if (cut != 0) {
            return clipped(name, again.camera(view), cut);
        }
        // Nothing of it is left, though no plane has all of it outside.
        return emitted ? std::nullopt
                       : std::optional(clipped(name, again.camera(view), corners.outside_any()));
    }
    if (emitted) {
        return std::nullopt;
    }
    return verdict_on(
        name, culled(corners, inquiry.surfaces[name.surface]).value_or(Verdict::no_pixel_center));
}

TriangleVerdict verdict_of_surface(PixelInquiry& inquiry, std::uint32_t surface) {
    TriangleName name{surface, 0, 0, 0, 0};
    const int slabs = inquiry.volume.has_shape() ? inquiry.volume.shape().slab_count() : 1;
    for (; name.k < slabs; ++name.k) {
        auto verdict = missing_data(inquiry, name);
        if (!verdict) {
            verdict = distrust(inquiry, name);
        }
        if (!verdict && inquiry.replayed->draws(surface, name.k)) {
            const ReplayedSlab& slab = inquiry.replayed->slab(surface, name.k, inquiry.place.view);
            verdict = removed_from_ray(inquiry, slab, surface, name.k);
        } else if (verdict) {
            verdict->name.reset();  // Not of a triangle but of all.
        }
        if (verdict) {
            return *verdict;
        }
    }
    TriangleVerdict nearest;
    nearest.surface = surface;
    for (const Primitive& p : inquiry.history.primitives) {
        if (inquiry.region().plan.parts[p.part].segment.surface != surface) {
            continue;
        }
        TriangleVerdict edge = farthest_edge(inquiry, p);
        if (edge.edge >= 0 && (nearest.edge < 0 || edge.distance_px < nearest.distance_px)) {
            nearest = std::move(edge);
            nearest.surface = surface;
            nearest.facts = inquiry.facts_of(p);
        }
    }
    nearest.verdict = Verdict::nothing;
    return nearest;
}

}  // namespace pxpl5::host::inspect
