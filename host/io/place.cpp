#include "host/io/place.hpp"

#include <fmt/format.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numbers>

namespace pxpl5::host::io {

namespace {

constexpr double max_orthogonal_cosine = 1e-4;  // 0.006 degrees: headers round their numbers.
constexpr double min_determinant = 1e-9;        // Of a box of the same spacings.

}  // namespace

void take_spacing(const std::string& file, const ImportRequest& request,
                  const std::array<bool, 3>& stated, Volume& volume) {
    std::string missing;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (stated[axis]) {
            continue;
        }
        missing += "xyz"[axis];
        if (request.spacing_mm) {
            const int column = static_cast<int>(axis);
            const glm::dvec3 direction =
                glm::normalize(glm::dvec3(volume.voxel_to_patient[column]));
            volume.voxel_to_patient[column] =
                glm::dvec4(direction * (*request.spacing_mm)[column], 0);
        }
    }
    if (request.spacing_mm && missing.empty()) {
        const auto& m = volume.voxel_to_patient;
        throw ImportError(fmt::format(
            "{}: states its spacing ({} x {} x {} mm), so none can be given (spacing={},{},{})",
            file, glm::length(glm::dvec3(m[0])), glm::length(glm::dvec3(m[1])),
            glm::length(glm::dvec3(m[2])), request.spacing_mm->x, request.spacing_mm->y,
            request.spacing_mm->z));
    }
    if (missing.empty()) {
        return;
    }
    volume.findings.insert(
        volume.findings.begin(),
        {FindingKind::assumption,
         request.spacing_mm
             ? fmt::format("the file does not state its spacing along {}: taken as asked for",
                           missing)
             : fmt::format("the file does not state its spacing along {}: 1 mm is assumed, sizes "
                           "and shapes may be wrong; spacing=x,y,z sets it",
                           missing)});
}

void check_place(const std::string& file, Volume& volume) {
    const glm::dmat3 linear(volume.voxel_to_patient);
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 3; ++row) {
            if (!std::isfinite(volume.voxel_to_patient[column][row])) {
                throw ImportError(fmt::format("{}: {} of axis {} is {}, must be finite", file,
                                              column < 3 ? "spacing or direction" : "the origin",
                                              "xyz"[column < 3 ? column : row],
                                              volume.voxel_to_patient[column][row]));
            }
        }
    }
    const double steps = glm::length(linear[0]) * glm::length(linear[1]) * glm::length(linear[2]);
    const double determinant = glm::determinant(linear);
    if (!(std::abs(determinant) > min_determinant * steps) || !std::isfinite(steps)) {
        throw ImportError(fmt::format(
            "{}: its axes span no volume: spacings {} x {} x {} mm, determinant {}", file,
            glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2]), determinant));
    }
    if (determinant < 0) {
        volume.findings.push_back({FindingKind::reflection,
                                   "the voxel axes are left-handed in the patient (reflection)"});
    }
    for (int axis = 0; axis < 3; ++axis) {
        const int next = (axis + 1) % 3;
        const double cosine = glm::dot(glm::normalize(linear[axis]), glm::normalize(linear[next]));
        if (std::abs(cosine) > max_orthogonal_cosine) {
            volume.findings.push_back(
                {FindingKind::gantry_tilt,
                 fmt::format("sheared: the {} and {} axes meet at {:.2f} degrees, as in a tilted "
                             "gantry",
                             "xyz"[axis], "xyz"[next],
                             std::acos(cosine) * 180 / std::numbers::pi)});
        }
    }
}

}  // namespace pxpl5::host::io
