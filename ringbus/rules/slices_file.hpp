// Values of a volume in a file, and how they become voxels: the io process and the GPs convert them
// alike. Plain.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <type_traits>

#include "generated/vocabulary.hpp"

namespace pxpl5 {

/// Most bytes of a volume whose values the host reads and sends. GPs can read larger volumes.
inline constexpr std::uint64_t max_volume_bytes = std::uint64_t{8} << 30;

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

inline std::size_t component_bytes(Component component) {
    return with_type(component, []<typename T>(T*) { return sizeof(T); });
}

/// value = stored * slope + intercept.
struct StoredScale {
    double slope = 1, intercept = 0;
    bool is_identity() const { return slope == 1 && intercept == 0; }
    friend bool operator==(const StoredScale&, const StoredScale&) = default;
};

template <typename T>
double scaled(T stored, const StoredScale& scale) {
    return scale.is_identity() ? static_cast<double>(stored)
                               : static_cast<double>(stored) * scale.slope + scale.intercept;
}

/// Size, inode and time of the last change of a file: equal if two computers see the same file, and
/// the file is unchanged.
struct FileFacts {
    std::uint64_t size_bytes = 0, inode = 0;
    std::int64_t modified_ns = 0;  ///< Since 1970.
    friend bool operator==(const FileFacts&, const FileFacts&) = default;
};

/// Raw values of a volume in a file: x fastest, then y, then z.
struct SlicesFile {
    std::string path;                ///< Absolute.
    std::uint64_t offset_bytes = 0;  ///< Before the first value.
    Component stored = Component::uint8;
    bool big_endian = false;
    StoredScale scale;
    FileFacts facts;
    friend bool operator==(const SlicesFile&, const SlicesFile&) = default;
};

/// Reverses the bytes of each value of `size` bytes.
inline void swap_bytes(std::span<std::byte> bytes, std::size_t size) {
    for (std::size_t at = 0; size > 1 && at + size <= bytes.size(); at += size) {
        std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                     bytes.begin() + static_cast<std::ptrdiff_t>(at + size));
    }
}

/// Converts one value. Returns false if To cannot represent it.
template <typename To>
bool convert_value(double value, To& to) {
    if constexpr (std::is_integral_v<To>) {
        if (!(value >= std::numeric_limits<To>::min() && value <= std::numeric_limits<To>::max())) {
            return false;
        }
    }
    to = static_cast<To>(value);
    return true;
}

template <typename From, typename To>
bool convert_values(std::span<const std::byte> stored, const StoredScale& scale,
                    std::span<std::byte> voxels) {
    bool fits = true;
    for (std::size_t i = 0; i < voxels.size() / sizeof(To); ++i) {
        From from{};
        To to{};
        std::memcpy(&from, stored.data() + i * sizeof(From), sizeof from);
        fits = convert_value(scaled(from, scale), to) && fits;
        std::memcpy(voxels.data() + i * sizeof(To), &to, sizeof to);
    }
    return fits;
}

/// Whether the stored values are the voxels, but for the order of their bytes.
inline bool are_voxels(const SlicesFile& file, Scalar type) {
    const Component same = type == Scalar::uint8    ? Component::uint8
                           : type == Scalar::int16  ? Component::int16
                           : type == Scalar::uint16 ? Component::uint16
                                                    : Component::float32;
    return file.stored == same && file.scale.is_identity();
}

/// Converts stored values to voxels of `type`.
/// stored  Values of the file. Their bytes are put into this machine's order.
/// voxels  As many, of `type`.
/// Returns false if a value does not fit into `type`: then the file is not the one of which the
///         type was chosen.
inline bool convert_stored(std::span<std::byte> stored, const SlicesFile& file, Scalar type,
                           std::span<std::byte> voxels) {
    if (file.big_endian) {
        swap_bytes(stored, component_bytes(file.stored));
    }
    if (are_voxels(file, type)) {
        std::copy(stored.begin(), stored.end(), voxels.begin());
        return true;
    }
    return with_type(file.stored, [&]<typename From>(From*) {
        switch (type) {
            case Scalar::uint8:
                return convert_values<From, std::uint8_t>(stored, file.scale, voxels);
            case Scalar::int16:
                return convert_values<From, std::int16_t>(stored, file.scale, voxels);
            case Scalar::uint16:
                return convert_values<From, std::uint16_t>(stored, file.scale, voxels);
            case Scalar::float32:
                break;
        }
        return convert_values<From, float>(stored, file.scale, voxels);
    });
}

}  // namespace pxpl5
