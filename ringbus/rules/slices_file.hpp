// Values of a volume in files, and how they become voxels: the io process and the GPs convert them
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
#include <vector>

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

/// Slices of a volume, one after the other in a file: x fastest, then y.
struct SlicesFile {
    std::string path;                ///< Absolute.
    std::uint64_t offset_bytes = 0;  ///< Before the first value.
    std::uint32_t slices = 1;
    StoredScale scale;
    FileFacts facts;
    friend bool operator==(const SlicesFile&, const SlicesFile&) = default;
};

/// Raw values of a volume. The slices of each file follow those of the file before it along z. A
/// file may occur again, with other slices of it.
struct StoredVolume {
    Component component = Component::uint8;
    bool big_endian = false;
    int bits_stored = 0;  ///< Lowest bits of a value that are in use; 0 for all.
    std::vector<SlicesFile> files;
    friend bool operator==(const StoredVolume&, const StoredVolume&) = default;
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

/// Clears the bits above the `stored` lowest ones of whole numbers: they become 0, or the sign.
/// values  In this machine's byte order.
/// stored  0 for all bits.
inline void clear_unused_bits(std::span<std::byte> values, Component component, int stored) {
    if (stored == 0 || stored == static_cast<int>(8 * component_bytes(component))) {
        return;
    }
    with_type(component, [&]<typename T>(T*) {
        if constexpr (std::is_integral_v<T>) {
            const int unused = static_cast<int>(8 * sizeof(T)) - stored;
            for (std::size_t at = 0; at + sizeof(T) <= values.size(); at += sizeof(T)) {
                std::make_unsigned_t<T> bits = 0;
                std::memcpy(&bits, values.data() + at, sizeof bits);
                bits = static_cast<std::make_unsigned_t<T>>(bits << unused);
                // The shift of a signed value repeats the sign.
                const T value = static_cast<T>(static_cast<T>(bits) >> unused);
                std::memcpy(values.data() + at, &value, sizeof value);
            }
        }
    });
}

/// Whether stored values are the voxels, but for the order of their bytes and unused bits.
inline bool are_voxels(Component stored, const StoredScale& scale, Scalar type) {
    const Component same = type == Scalar::uint8    ? Component::uint8
                           : type == Scalar::int16  ? Component::int16
                           : type == Scalar::uint16 ? Component::uint16
                                                    : Component::float32;
    return stored == same && scale.is_identity();
}

/// Puts the bytes of stored values into this machine's order, and clears bits that are not in use.
inline void read_stored(std::span<std::byte> stored, const StoredVolume& volume) {
    if (volume.big_endian) {
        swap_bytes(stored, component_bytes(volume.component));
    }
    clear_unused_bits(stored, volume.component, volume.bits_stored);
}

/// Converts values of read_stored() to voxels of `type`.
/// voxels  As many, of `type`.
/// Returns false if a value does not fit into `type`: then the file is not the one of which the
///         type was chosen.
inline bool convert_stored(std::span<const std::byte> stored, Component component,
                           const StoredScale& scale, Scalar type, std::span<std::byte> voxels) {
    if (are_voxels(component, scale, type)) {
        std::copy(stored.begin(), stored.end(), voxels.begin());
        return true;
    }
    return with_type(component, [&]<typename From>(From*) {
        switch (type) {
            case Scalar::uint8:
                return convert_values<From, std::uint8_t>(stored, scale, voxels);
            case Scalar::int16:
                return convert_values<From, std::int16_t>(stored, scale, voxels);
            case Scalar::uint16:
                return convert_values<From, std::uint16_t>(stored, scale, voxels);
            case Scalar::float32:
                break;
        }
        return convert_values<From, float>(stored, scale, voxels);
    });
}

}  // namespace pxpl5
