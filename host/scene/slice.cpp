#include "host/scene/slice.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/mat3x3.hpp>
#include <utility>

#include "host/scene/overlay.hpp"
#include "host/scene/slice_places.hpp"
#include "host/volume/reduced.hpp"
#include "host/volume/scalar_types.hpp"

namespace pxpl5::host {

namespace {

/// Directions in the patient that a picture's right and lower side shall show.
struct WishedSides {
    glm::dvec3 right, down;
};

/// normal  Of the slice's plane; either way.
WishedSides wished_sides(const glm::dvec3& normal) {
    const glm::dvec3 n = glm::abs(normal), left(1, 0, 0), posterior(0, 1, 0), inferior(0, 0, -1);
    if (n.z >= n.x - direction_rounding && n.z >= n.y - direction_rounding) {
        return {left, posterior};
    }
    return n.y >= n.x - direction_rounding ? WishedSides{left, inferior}
                                           : WishedSides{posterior, inferior};
}

std::size_t index_of(int i) {
    return static_cast<std::size_t>(i);
}

SliceSide side_of(const Volume& volume, int axis, const glm::dvec3& wish) {
    const std::array counts = {volume.nx, volume.ny, volume.nz};
    const glm::dvec3 step_mm(volume.voxel_to_patient[axis]);
    SliceSide side;
    side.axis = axis;
    side.is_flipped = glm::dot(step_mm, wish) < 0;
    side.count = counts[index_of(axis)];
    const bool is_uneven = axis == 2 && !volume.slice_places.empty();
    const double last =
        is_uneven ? volume.slice_places.back() - volume.slice_places.front() : side.count - 1;
    const double length_mm = glm::length(step_mm);
    side.spacing_mm = side.count > 1 ? length_mm * last / (side.count - 1) : length_mm;
    for (int i = 0; is_uneven && i < side.count; ++i) {
        const auto& places = volume.slice_places;
        side.places_mm.push_back(
            length_mm * (side.is_flipped ? places.back() - places[index_of(side.count - 1 - i)]
                                         : places[index_of(i)] - places.front()));
    }
    const glm::dvec3 direction = side.is_flipped ? -step_mm : step_mm;
    side.begin = direction_letters(-direction);
    side.end = direction_letters(direction);
    return side;
}

/// Corners of a square in picture order: top left, top right, bottom right, bottom left.
struct Square {
    std::array<double, 4> values;
    int x = 0, y = 0;  ///< Position of the top left corner.
};

/// Where the contour crosses the side from corner k to the next one.
glm::vec2 crossing(const Square& square, std::size_t k, double isovalue) {
    static constexpr std::array<std::array<int, 2>, 4> corners = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    const std::size_t next = (k + 1) % 4;
    double t = (isovalue - square.values[k]) / (square.values[next] - square.values[k]);
    t = t >= 0 && t <= 1 ? t : 0.5;  // Same as in extraction, if a value is not finite.
    const auto along = [&](std::size_t c) {
        return corners[k][c] + t * (corners[next][c] - corners[k][c]);
    };
    return {static_cast<float>(square.x + along(0)), static_cast<float>(square.y + along(1))};
}

/// Whether the inside corners of a square that has two across are joined. As in extraction: the
/// saddle's sign, and apart if it lies on the isovalue.
bool is_joined(const std::array<double, 4>& values, double isovalue) {
    const double even = (values[0] - isovalue) * (values[2] - isovalue);
    const double odd = (values[1] - isovalue) * (values[3] - isovalue);
    return values[0] >= isovalue ? even > odd : odd > even;
}

void cut_square(const Square& square, double isovalue, SaddleRule rule,
                std::vector<ContourPiece>& pieces) {
    const auto inside = [&](std::size_t k) { return square.values[k % 4] >= isovalue; };
    const auto at = [&](std::size_t side) { return crossing(square, side % 4, isovalue); };
    const bool is_saddle = inside(0) == inside(2) && inside(1) == inside(3);
    const bool joined =
        is_saddle && rule == SaddleRule::asymptotic && is_joined(square.values, isovalue);
    // Going around clockwise, each run of inside corners is entered on one side and left on
    // another. Inside corners that are joined are bridged: what is cut off are runs outside.
    for (std::size_t entry = 0; entry < 4; ++entry) {
        if (inside(entry) || !inside(entry + 1)) {
            continue;
        }
        std::size_t exit = entry + 1;
        while (inside(exit + 1)) {
            ++exit;
        }
        pieces.push_back(joined ? ContourPiece{at(entry + 3), at(entry)}
                                : ContourPiece{at(exit), at(entry)});
    }
}

/// Bytes from a voxel to its neighbor along each axis.
using Strides = std::array<std::size_t, 3>;

Strides strides_of(const std::array<int, 3>& counts, Scalar type) {
    const std::size_t size = size_bytes(type), row = size * index_of(counts[0]);
    return {size, row, row * index_of(counts[1])};
}

/// The values of a plane as the picture shows them. `plane` is the voxel with the lowest indices.
Slice arranged(SliceFrame frame, Scalar type, const std::byte* plane, const Strides& strides) {
    Slice slice{std::move(frame), type, {}};
    const std::size_t size = size_bytes(type);
    const SliceSide &across = slice.frame.across, &down = slice.frame.down;
    const auto offset = [&](const SliceSide& side, int i) {
        return strides[index_of(side.axis)] * index_of(side.is_flipped ? side.count - 1 - i : i);
    };
    slice.values.resize(size * index_of(across.count) * index_of(down.count));
    std::byte* to = slice.values.data();
    for (int y = 0; y < down.count; ++y) {
        const std::byte* row = plane + offset(down, y);
        for (int x = 0; x < across.count; ++x, to += size) {
            std::memcpy(to, row + offset(across, x), size);
        }
    }
    return slice;
}

}  // namespace

double SliceSide::place_mm(double number) const {
    return places_mm.empty() ? number * spacing_mm : place_of_slice(number, places_mm);
}

double SliceSide::number_at(double mm) const {
    return places_mm.empty() ? mm / spacing_mm : slice_of_place(mm, places_mm);
}

SliceFrame slice_frame(const Volume& volume, int axis) {
    assert(axis >= 0 && axis < 3);
    const int first = axis == 0 ? 1 : 0, second = axis == 2 ? 1 : 2;
    const glm::dmat3 steps(volume.voxel_to_patient);
    const glm::dvec3 u = glm::normalize(steps[first]), v = glm::normalize(steps[second]);
    const WishedSides wish = wished_sides(glm::normalize(glm::cross(u, v)));
    const auto fit = [&](const glm::dvec3& right, const glm::dvec3& down) {
        return std::abs(glm::dot(right, wish.right)) + std::abs(glm::dot(down, wish.down));
    };
    const bool is_turned = fit(v, u) > fit(u, v) + direction_rounding;
    SliceFrame frame;
    frame.across = side_of(volume, is_turned ? second : first, wish.right);
    frame.down = side_of(volume, is_turned ? first : second, wish.down);
    frame.through = axis;
    const double cosine = std::min(std::abs(glm::dot(u, v)), 1.0);
    frame.skew_deg = std::asin(cosine) / glm::pi<double>() * 180;
    return frame;
}

Slice slice_of(const Volume& whole, int axis, int index) {
    assert(index >= 0 && index < (axis == 0 ? whole.nx : axis == 1 ? whole.ny : whole.nz));
    const Volume& volume = kept(whole);
    const std::array counts = {volume.nx, volume.ny, volume.nz};
    const Strides strides = strides_of(counts, volume.type);
    return arranged(
        slice_frame(volume, axis), volume.type,
        volume.values.data() + strides[index_of(axis)] * index_of(index / whole.reduction),
        strides);
}

Slice slice_of_plane(const Volume& volume, int axis, std::span<const std::byte> values) {
    std::array counts = {volume.nx, volume.ny, volume.nz};
    counts[index_of(axis)] = 1;
    assert(values.size() == size_bytes(volume.type) * index_of(counts[0]) * index_of(counts[1]) *
                                index_of(counts[2]));
    return arranged(slice_frame(volume, axis), volume.type, values.data(),
                    strides_of(counts, volume.type));
}

std::vector<double> numbers_of(const Slice& slice) {
    std::vector<double> numbers;
    numbers.reserve(slice.values.size() / size_bytes(slice.type));
    with_scalar(slice.type, [&]<typename T>(T*) {
        T value{};
        for (std::size_t at = 0; at < slice.values.size(); at += sizeof value) {
            std::memcpy(&value, slice.values.data() + at, sizeof value);
            numbers.push_back(static_cast<double>(value));
        }
    });
    return numbers;
}

SaddleRule saddle_rule(CaseRule table) {
    return table == CaseRule::asymptotic ? SaddleRule::asymptotic : SaddleRule::apart;
}

std::vector<ContourPiece> slice_contour(const SliceFrame& frame, const std::vector<double>& numbers,
                                        double isovalue, SaddleRule rule) {
    const std::size_t width = index_of(frame.across.count);
    assert(numbers.size() == width * index_of(frame.down.count));
    std::vector<ContourPiece> pieces;
    for (int y = 0; y + 1 < frame.down.count; ++y) {
        const double* row = numbers.data() + width * index_of(y);
        for (int x = 0; x + 1 < frame.across.count; ++x) {
            const double* v = row + x;
            const Square square{{v[0], v[1], v[width + 1], v[width]}, x, y};
            cut_square(square, isovalue, rule, pieces);
        }
    }
    return pieces;
}

}  // namespace pxpl5::host
