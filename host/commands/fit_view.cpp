#include "host/commands/fit_view.hpp"

#include <algorithm>
#include <glm/common.hpp>
#include <limits>
#include <optional>

#include "host/commands/command_handlers.hpp"
#include "host/scene/slice_places.hpp"
#include "host/volume/reduced.hpp"
#include "host/volume/typed_values.hpp"

namespace pxpl5::host {

namespace {

/// Share of a square picture for the surfaces; the rest is for letters.
constexpr double fitted_share = 0.86;

/// Voxels, both ends included.
struct Box {
    glm::ivec3 first{std::numeric_limits<int>::max()}, last{-1};
};

/// The box of all voxels at or above `isovalue`. Its last voxel is -1 if there is none. A reduced
/// copy does not show what lies between its voxels, so that its box reaches to the next ones.
Box box_above(const Volume& whole, double isovalue) {
    const Volume& volume = kept(whole);
    Box box;
    with_values(volume, [&](auto values) {
        const auto row_length = static_cast<std::size_t>(volume.nx);
        const auto is_inside = [isovalue](auto value) {
            return static_cast<double>(value) >= isovalue;
        };
        for (int z = 0, row = 0; z < volume.nz; ++z) {
            for (int y = 0; y < volume.ny; ++y, ++row) {
                const auto voxels =
                    values.subspan(static_cast<std::size_t>(row) * row_length, row_length);
                const auto first = std::ranges::find_if(voxels, is_inside);
                if (first == voxels.end()) {
                    continue;
                }
                const auto last = std::find_if(voxels.rbegin(), voxels.rend(), is_inside);
                box.first =
                    glm::min(box.first, glm::ivec3(static_cast<int>(first - voxels.begin()), y, z));
                box.last = glm::max(box.last,
                                    glm::ivec3(static_cast<int>(voxels.rend() - last) - 1, y, z));
            }
        }
    });
    if (whole.reduced && box.last.x >= 0) {
        box.first = glm::max((box.first - 1) * whole.reduction, 0);
        box.last = glm::min((box.last + 1) * whole.reduction,
                            glm::ivec3(whole.nx, whole.ny, whole.nz) - 1);
    }
    return box;
}

}  // namespace

Camera fitted_to_surfaces(const Volume& volume, std::span<const Surface> surfaces,
                          const Camera& camera) {
    const glm::ivec3 end = glm::ivec3(volume.nx, volume.ny, volume.nz) - 1;
    std::optional<double> least;
    for (const Surface& surface : surfaces) {
        if (surface.visible) {
            least = std::min(least.value_or(surface.isovalue), surface.isovalue);
        }
    }
    Box box{glm::ivec3(0), end};
    if (const Box above = least ? box_above(volume, *least) : box; above.last.x >= 0) {
        // A surface lies between a voxel inside and the next one.
        box = {glm::max(above.first - 1, 0), glm::min(above.last + 1, end)};
    }
    const Subject subject =
        subject_of(glm::dvec3(end.x, end.y, last_place(volume)), volume.voxel_to_patient);
    Camera fit = fitted(camera, subject, corners_mm(volume, box.first, box.last), fitted_share);
    fit.zoom = std::clamp(fit.zoom, min_zoom, max_zoom);
    return fit;
}

Camera fitted_to_surfaces(const Session& session, const Camera& camera) {
    return session.volumes.has_volume()
               ? fitted_to_surfaces(session.volumes.volume(), session.scene.surfaces, camera)
               : camera;
}

}  // namespace pxpl5::host
