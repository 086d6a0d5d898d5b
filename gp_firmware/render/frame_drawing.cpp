#include "gp_firmware/render/frame_drawing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <utility>

#include "gp_firmware/render/draw_scene.hpp"

namespace pxpl5::gp {

bool draws_slab(SlabChoice choice, int slab, std::span<const int> gap_slabs) {
    return choice == SlabChoice::all ||
           (choice == SlabChoice::in_gaps) == std::ranges::binary_search(gap_slabs, slab);
}

std::size_t region_count(const FrameRequest& request) {
    std::size_t count = 0;
    for (const Camera& camera : request.views) {
        count +=
            static_cast<std::size_t>(region_grid(camera.width_px, camera.height_px, 0).count());
    }
    return count;
}

std::vector<SlicePlane> slice_planes_of(const FrameRequest& request) {
    std::vector<SlicePlane> planes;
    for (const SurfaceWanted& wanted : request.surfaces) {
        if (wanted.plane) {
            planes.push_back(*wanted.plane);
        }
    }
    return planes;
}

std::string missing_surface(const FrameRequest& request, const Surfaces& surfaces) {
    for (const SurfaceWanted& wanted : request.surfaces) {
        if (wanted.plane) {
            continue;
        }
        const auto held = surfaces.find(wanted.surface);
        if (held == surfaces.end()) {
            return fmt::format("frame {} shows surface {}, which is not held", request.frame,
                               wanted.surface);
        }
        if (held->second.revision != wanted.revision || !held->second.complete) {
            return fmt::format("frame {} shows revision {} of surface {}, held is {}revision {}",
                               request.frame, wanted.revision, wanted.surface,
                               held->second.complete ? "" : "a part of ", held->second.revision);
        }
    }
    return {};
}

void FrameDrawing::begin(const FrameRequest& request) {
    programs_.begin_frame(request.assignment.size(), request.origins);
    counts_ = {};
    drawn_.clear();
    next_surface_ = next_slab_ = 0;
    next_piece_ = 0;
    wanted_.clear();
    eyes_.clear();
    gray_eyes_.clear();
    if (request.surfaces.empty()) {
        return;  // Without surfaces there may be no volume, and so no valid projection.
    }
    int view = 0;
    for (const Camera& camera : request.views) {
        eyes_.push_back({prepare(camera), region_grid(camera.width_px, camera.height_px, view++)});
        gray_eyes_.push_back({with_gray_values(eyes_.back().projection), eyes_.back().grid});
    }
    assert(static_cast<std::size_t>(view * eyes_[0].grid.count()) == request.assignment.size());
    wanted_ = request.surfaces;
    gap_slabs_ = request.gap_slabs;
}

bool FrameDrawing::draw(Surfaces& surfaces, std::size_t triangle_count,
                        const ExtractLeftOut& extract, const PlaneSource& planes) {
    const std::size_t enough = counts_.triangles_in + triangle_count;
    for (; next_surface_ < wanted_.size(); ++next_surface_, next_slab_ = 0) {
        const SurfaceWanted& wanted = wanted_[next_surface_];
        if (wanted.plane ? draw_plane(*wanted.plane, enough, planes)
                         : draw_surface(surfaces.at(wanted.surface), enough, extract)) {
            return true;
        }
    }
    programs_.end_frame();
    return false;
}

bool FrameDrawing::draw_surface(HeldSurface& held, std::size_t enough,
                                const ExtractLeftOut& extract) {
    const SurfaceWanted& wanted = wanted_[next_surface_];
    SimplifiedSurface* const simplified =
        wanted.detail == 0 ? nullptr : &held.simplified.at({wanted.detail, wanted.slabs});
    std::vector<SlabMesh>& slabs = simplified ? simplified->blocks : held.slabs;
    if (simplified != nullptr) {
        counts_.moved_mm = std::max(counts_.moved_mm, simplified->moved_mm);
    }
    SurfaceStyle style{static_cast<std::uint16_t>(next_surface_), wanted.cull_back};
    for (; next_slab_ < slabs.size(); ++next_slab_) {
        if (counts_.triangles_in >= enough) {
            return true;
        }
        SlabMesh& mesh = slabs[next_slab_];
        if (simplified == nullptr) {
            if (!draws_slab(wanted.slabs, mesh.slab, gap_slabs_)) {
                continue;
            }
            if (!held.hidden.empty()) {
                style.hidden = held.hidden[next_slab_];
            }
        }
        if (mesh.left_out) {  // Extracting it is a piece of work.
            draw_slab_or_block(extract(held, mesh), style);
            ++next_slab_;
            return true;
        }
        draw_slab_or_block(mesh, style);
    }
    return false;
}

bool FrameDrawing::draw_plane(const SlicePlane& plane, std::size_t enough,
                              const PlaneSource& planes) {
    const SurfaceStyle style{static_cast<std::uint16_t>(next_surface_), false};
    for (; next_slab_ < planes.slabs; ++next_slab_, next_piece_ = 0) {
        while (const SlabMesh* const mesh = planes.piece(plane, next_slab_, next_piece_)) {
            if (next_piece_ == 0) {
                programs_.begin_slab(style.index, static_cast<std::uint32_t>(mesh->slab));
                drawn_.push_back({style.index, static_cast<std::uint32_t>(mesh->slab), 0, 0});
            }
            draw_part(*mesh, style, gray_eyes_);
            ++next_piece_;
            if (counts_.triangles_in >= enough || planes.is_packed) {
                return true;
            }
        }
    }
    return false;
}

void FrameDrawing::draw_slab_or_block(const SlabMesh& mesh, const SurfaceStyle& style) {
    programs_.begin_slab(style.index, static_cast<std::uint32_t>(mesh.slab));
    drawn_.push_back({style.index, static_cast<std::uint32_t>(mesh.slab), 0, 0});
    draw_part(mesh, style, eyes_);
    if (drawn_.back().primitives == 0) {
        drawn_.pop_back();
    }
}

void FrameDrawing::draw_part(const SlabMesh& mesh, const SurfaceStyle& style,
                             std::span<const Eye> eyes) {
    const auto primitives = static_cast<std::uint32_t>(mesh.indices.size() / 3 +
                                                       mesh.spheres.size() + mesh.lines.size());
    counts_.triangles_in += primitives;
    for (const Eye& eye : eyes) {
        drawn_.back().primitives += primitives;
        drawn_.back().culled += primitives - draw_for(eye, mesh, style);
    }
}

std::uint32_t FrameDrawing::draw_for(const Eye& eye, const SlabMesh& mesh,
                                     const SurfaceStyle& style) {
    const DrawCounts triangles =
        draw_slab(mesh, eye.projection, eye.grid, style, scratch_, programs_);
    const DrawCounts spheres = draw_spheres(mesh, eye.projection, eye.grid, style, programs_);
    const DrawCounts lines = draw_lines(mesh, eye.projection, eye.grid, style, programs_);
    counts_.triangles_out += triangles.triangles_out + spheres.triangles_out + lines.triangles_out;
    counts_.transform_ns += triangles.transform_ns;
    return triangles.drawn + spheres.drawn + lines.drawn;
}

}  // namespace pxpl5::gp
