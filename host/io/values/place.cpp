#include "host/io/values/place.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numbers>

namespace pxpl5::host::io {

namespace {

constexpr double min_shear_degrees = 0.1;  // Headers round their numbers.
constexpr double min_determinant = 1e-9;   // Share of a box of the same spacings.

// From below the wavelength of light to more than a patient. Within these no area, volume or
// distance of a surface overflows, and the ring takes what is derived from them.
constexpr double min_file_spacing_mm = 1e-6, max_file_spacing_mm = 1e6;
constexpr double max_corner_mm = 1e6;    // Limit of ringbus for places of a scene.
constexpr double max_slice_place = 1e6;  // Limit of ringbus for slice_places.

void check_spacings(const std::string& file, const glm::dmat3& linear) {
    for (int axis = 0; axis < 3; ++axis) {
        const double spacing = glm::length(linear[axis]);
        if (!(spacing >= min_file_spacing_mm && spacing <= max_file_spacing_mm)) {
            throw ImportError(fmt::format("{}: spacing along {} is {} mm, must be {} to {} mm",
                                          file, "xyz"[axis], spacing, min_file_spacing_mm,
                                          max_file_spacing_mm));
        }
    }
}

/// The volume's eight corners and its slices lie where the ring and the graphics can take them.
void check_corners(const std::string& file, const Volume& volume) {
    const double last_place =
        volume.slice_places.empty() ? volume.nz - 1 : volume.slice_places.back();
    if (!(last_place <= max_slice_place)) {
        throw ImportError(fmt::format("{}: its last slice lies {} steps from the first, at most {}",
                                      file, last_place, max_slice_place));
    }
    const glm::dvec3 last(volume.nx - 1, volume.ny - 1, last_place);
    for (unsigned corner = 0; corner < 8; ++corner) {
        const glm::dvec3 at(corner & 1U ? last.x : 0, corner & 2U ? last.y : 0,
                            corner & 4U ? last.z : 0);
        const glm::dvec3 place_mm(volume.voxel_to_patient * glm::dvec4(at, 1));
        for (int row = 0; row < 3; ++row) {
            if (!(std::abs(place_mm[row]) <= max_corner_mm)) {
                throw ImportError(
                    fmt::format("{}: {} of voxel {},{},{} is {} mm, must be within +-{} mm", file,
                                "xyz"[row], at.x, at.y, at.z, place_mm[row], max_corner_mm));
            }
        }
    }
}

/// The unit vectors, LPS, of three letters: one of L and R, of P and A, of S and I, in any order.
glm::dmat3 directions_of(const std::string& file, const std::string& letters) {
    glm::dmat3 axes(0);
    unsigned seen = 0;
    for (std::size_t i = 0; i < std::min<std::size_t>(letters.size(), 3); ++i) {
        const std::size_t plus = std::string_view("LPS").find(letters[i]),
                          minus = std::string_view("RAI").find(letters[i]);
        const std::size_t side = std::min(plus, minus);
        if (side < 3) {
            axes[static_cast<int>(i)][static_cast<int>(side)] = plus < 3 ? 1 : -1;
            seen |= 1U << side;
        }
    }
    if (letters.size() != 3 || seen != 7) {
        throw ImportError(
            fmt::format("{}: orientation is '{}', must have one of L and R, one of P "
                        "and A, one of S and I: the sides to which x, y, z point",
                        file, letters));
    }
    return axes;
}

}  // namespace

glm::dmat4 to_lps(glm::dmat4 ras) {
    for (int column = 0; column < 4; ++column) {
        ras[column].x = 0 - ras[column].x;  // Not a bare minus: zeros stay positive.
        ras[column].y = 0 - ras[column].y;
    }
    return ras;
}

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
        request.spacing_mm
            ? Finding{FindingKind::note,
                      fmt::format(
                          "the file does not state its spacing along {}: taken as asked for",
                          missing)}
            : Finding{FindingKind::assumption,
                      fmt::format("the file does not state its spacing along {}: 1 mm is assumed, "
                                  "sizes and shapes may be wrong; spacing=x,y,z sets it",
                                  missing)});
}

void take_directions(const std::string& file, const ImportRequest& request,
                     const std::string& assumption, Volume& volume) {
    const bool is_asked = !request.orientation.empty() || request.origin_mm;
    if (is_asked && assumption.empty()) {
        throw ImportError(file +
                          ": states its place in the patient, so orientation= and origin= "
                          "cannot be given");
    }
    if (assumption.empty()) {
        return;
    }
    glm::dmat4& m = volume.voxel_to_patient;
    std::string given;
    if (!request.orientation.empty()) {
        const glm::dmat3 turn = directions_of(file, request.orientation);
        for (int axis = 0; axis < 3; ++axis) {
            m[axis] = glm::dvec4(turn[axis] * glm::length(glm::dvec3(m[axis])), 0);
        }
        m[3] = glm::dvec4(turn * glm::dvec3(m[3]), 1);
        given = "x, y, z point to " + request.orientation;
    }
    if (request.origin_mm) {
        m[3] = glm::dvec4(*request.origin_mm, 1);
        given +=
            fmt::format("{}the first voxel is at {}, {}, {} mm (LPS)", given.empty() ? "" : ", ",
                        request.origin_mm->x, request.origin_mm->y, request.origin_mm->z);
    }
    const bool is_turned = !request.orientation.empty();
    const bool is_placed = request.origin_mm || m[3] != glm::dvec4(0, 0, 0, 1);
    std::string text =
        is_turned ? "the file states no orientation: " + given + ", as asked for" : assumption;
    if (is_turned && !is_placed) {
        text += "; the first voxel is taken as at 0, 0, 0 mm: origin=X,Y,Z sets its place";
    } else if (!is_turned && !given.empty()) {
        text += "; " + given + ", as asked for";
    }
    volume.findings.insert(
        volume.findings.begin(),
        {is_turned && is_placed ? FindingKind::note : FindingKind::assumption, text});
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
    check_spacings(file, linear);
    const double steps = glm::length(linear[0]) * glm::length(linear[1]) * glm::length(linear[2]);
    const double determinant = glm::determinant(linear);
    if (!(std::abs(determinant) > min_determinant * steps)) {
        throw ImportError(fmt::format(
            "{}: its axes span no volume: spacings {} x {} x {} mm, determinant {}", file,
            glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2]), determinant));
    }
    check_corners(file, volume);
    if (determinant < 0) {
        volume.findings.push_back({FindingKind::reflection,
                                   "the voxel axes are left-handed in the patient (reflection)"});
    }
    for (int axis = 0; axis < 3; ++axis) {
        const int next = (axis + 1) % 3;
        const double cosine = glm::dot(glm::normalize(linear[axis]), glm::normalize(linear[next]));
        const double angle = std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
        if (std::abs(angle - 90) >= min_shear_degrees) {
            const bool is_ct = volume.modality == "CT";
            volume.findings.push_back(
                {is_ct ? FindingKind::gantry_tilt : FindingKind::note,
                 fmt::format("sheared: the {} and {} axes meet at {:.2f} degrees{}", "xyz"[axis],
                             "xyz"[next], angle, is_ct ? ", as in a tilted gantry" : "")});
        }
    }
}

}  // namespace pxpl5::host::io
