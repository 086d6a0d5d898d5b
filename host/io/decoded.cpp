#include "host/io/decoded.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <glm/matrix.hpp>
#include <limits>
#include <numbers>
#include <span>
#include <type_traits>

#include "host/io/import.hpp"

namespace pxpl5::host::io {

namespace {

constexpr double max_orthogonal_cosine = 1e-4;  // 0.006 degrees: headers round their numbers.

/// Calls `f` with a null pointer of the C++ type of `component`.
template <typename F>
auto with_type(Component component, F&& f) {
    switch (component) {
        case Component::uint8:
            return f(static_cast<std::uint8_t*>(nullptr));
        case Component::int8:
            return f(static_cast<std::int8_t*>(nullptr));
        case Component::uint16:
            return f(static_cast<std::uint16_t*>(nullptr));
        case Component::int16:
            return f(static_cast<std::int16_t*>(nullptr));
        case Component::uint32:
            return f(static_cast<std::uint32_t*>(nullptr));
        case Component::int32:
            return f(static_cast<std::int32_t*>(nullptr));
        case Component::uint64:
            return f(static_cast<std::uint64_t*>(nullptr));
        case Component::int64:
            return f(static_cast<std::int64_t*>(nullptr));
        case Component::float32:
            return f(static_cast<float*>(nullptr));
        case Component::float64:
            break;
    }
    return f(static_cast<double*>(nullptr));
}

struct Range {
    double minimum = std::numeric_limits<double>::infinity();
    double maximum = -std::numeric_limits<double>::infinity();
    std::uint64_t not_finite = 0;
    bool whole = true;  ///< Every finite value is a whole number.

    bool within(double low, double high) const { return minimum >= low && maximum <= high; }
};

template <typename T>
std::span<const T> values_of(const std::vector<std::byte>& bytes) {
    // Vectors of bytes come from operator new, which aligns for every scalar type.
    return {reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)};
}

template <typename T>
Range range_of(std::span<const T> values) {
    Range range;
    for (const T value : values) {
        const auto number = static_cast<double>(value);
        if constexpr (std::is_floating_point_v<T>) {
            if (!std::isfinite(value)) {
                ++range.not_finite;
                continue;
            }
            range.whole = range.whole && std::trunc(value) == value;
        }
        range.minimum = std::min(range.minimum, number);
        range.maximum = std::max(range.maximum, number);
    }
    return range;
}

template <typename T>
bool fits(const Range& range) {
    return range.within(static_cast<double>(std::numeric_limits<T>::min()),
                        static_cast<double>(std::numeric_limits<T>::max()));
}

/// The type that `component` becomes.
Scalar target_type(Component component, bool scaled_integers, const Range& range) {
    const bool is_float = component == Component::float32 || component == Component::float64;
    switch (component) {
        case Component::uint8:
            return Scalar::uint8;
        case Component::int8:
        case Component::int16:
            return Scalar::int16;
        case Component::uint16:
            return Scalar::uint16;
        default:
            break;
    }
    if (is_float && (!scaled_integers || !range.whole || range.not_finite > 0)) {
        return Scalar::float32;
    }
    return fits<std::int16_t>(range)    ? Scalar::int16
           : fits<std::uint16_t>(range) ? Scalar::uint16
                                        : Scalar::float32;
}

const char* scalar_name(Scalar type) {
    switch (type) {
        case Scalar::uint8:
            return "uint8";
        case Scalar::int16:
            return "int16";
        case Scalar::uint16:
            return "uint16";
        case Scalar::float32:
            break;
    }
    return "float32";
}

/// Converts every value to To and counts those that lose something by it.
template <typename To, typename From>
std::uint64_t convert(std::span<const From> from, std::vector<std::byte>& bytes) {
    bytes.resize(from.size() * sizeof(To));
    auto* to = reinterpret_cast<To*>(bytes.data());
    std::uint64_t inexact = 0;
    for (std::size_t index = 0; index < from.size(); ++index) {
        to[index] = static_cast<To>(from[index]);
        const bool same =
            static_cast<long double>(to[index]) == static_cast<long double>(from[index]);
        const bool both_nan = from[index] != from[index] && to[index] != to[index];
        inexact += same || both_nan ? 0U : 1U;
    }
    return inexact;
}

template <typename From>
std::uint64_t convert_to(Scalar type, std::span<const From> from, std::vector<std::byte>& bytes) {
    switch (type) {
        case Scalar::uint8:
            return convert<std::uint8_t>(from, bytes);
        case Scalar::int16:
            return convert<std::int16_t>(from, bytes);
        case Scalar::uint16:
            return convert<std::uint16_t>(from, bytes);
        case Scalar::float32:
            break;
    }
    return convert<float>(from, bytes);
}

void take_values(const std::string& file, Decoded& decoded, Volume& volume) {
    with_type(decoded.component, [&]<typename T>(T*) {
        const std::span<const T> values = values_of<T>(decoded.values);
        Range range = range_of(values);
        if (range.not_finite == values.size()) {
            throw ImportError(
                fmt::format("{}: none of its {} values is finite", file, values.size()));
        }
        if (range.not_finite > 0) {
            volume.findings.push_back(
                {FindingKind::note,
                 fmt::format("{} of {} values are not finite", range.not_finite, values.size())});
        }
        volume.type = target_type(decoded.component, decoded.scaled_integers, range);
        const char* from = component_name(decoded.component);
        const char* to = scalar_name(volume.type);
        if (std::string_view(from) == to) {
            volume.values = std::move(decoded.values);
        } else {
            const std::uint64_t inexact = convert_to(volume.type, values, volume.values);
            volume.findings.push_back(
                {FindingKind::conversion,
                 inexact == 0 ? fmt::format("{} values are held as {}, without loss", from, to)
                              : fmt::format("{} values are held as {}: {} of {} are rounded", from,
                                            to, inexact, values.size())});
            decoded.values = {};
            if (volume.type == Scalar::float32) {
                range = range_of(values_of<float>(volume.values));
            }
        }
        volume.minimum = range.minimum;
        volume.maximum = range.maximum;
    });
}

void check_place(const std::string& file, Volume& volume) {
    const glm::dmat3 linear(volume.voxel_to_patient);
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 3; ++row) {
            if (!std::isfinite(volume.voxel_to_patient[column][row])) {
                throw ImportError(file + ": spacing, direction or origin is not a finite number");
            }
        }
    }
    const double steps = glm::length(linear[0]) * glm::length(linear[1]) * glm::length(linear[2]);
    const double determinant = glm::determinant(linear);
    if (!(std::abs(determinant) > 1e-9 * steps)) {
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

}  // namespace

const char* component_name(Component component) {
    constexpr std::array names = {"uint8", "int8",   "uint16", "int16",   "uint32",
                                  "int32", "uint64", "int64",  "float32", "float64"};
    return names.at(static_cast<std::size_t>(component));
}

std::size_t component_bytes(Component component) {
    return with_type(component, []<typename T>(T*) { return sizeof(T); });
}

void widen_to_float64(Decoded& decoded) {
    std::vector<std::byte> wide;
    with_type(decoded.component,
              [&]<typename T>(T*) { convert<double>(values_of<T>(decoded.values), wide); });
    decoded.values = std::move(wide);
    decoded.component = Component::float64;
}

Volume to_volume(const std::string& file, Decoded&& decoded) {
    std::size_t voxels = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (decoded.dims[axis] < min_dim || decoded.dims[axis] > max_dim) {
            throw ImportError(fmt::format("{}: {} voxels along {}, must be {} to {}", file,
                                          decoded.dims[axis], "xyz"[axis], min_dim, max_dim));
        }
        voxels *= static_cast<std::size_t>(decoded.dims[axis]);
    }
    assert(decoded.values.size() == voxels * component_bytes(decoded.component));
    Volume volume;
    volume.nx = decoded.dims[0];
    volume.ny = decoded.dims[1];
    volume.nz = decoded.dims[2];
    volume.voxel_to_patient = decoded.voxel_to_patient;
    for (std::string& note : decoded.notes) {
        volume.findings.push_back({FindingKind::note, std::move(note)});
    }
    check_place(file, volume);
    take_values(file, decoded, volume);
    return volume;
}

}  // namespace pxpl5::host::io
