// The types of value that files hold, before they become one of our four.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace pxpl5::host::io {

enum class Component : std::uint8_t {
    uint8,
    int8,
    uint16,
    int16,
    uint32,
    int32,
    uint64,
    int64,
    float32,
    float64
};

/// "uint8", "int8", ...: the names that a raw file's description uses, too.
constexpr const char* component_name(Component component) {
    constexpr std::array names = {"uint8", "int8",   "uint16", "int16",   "uint32",
                                  "int32", "uint64", "int64",  "float32", "float64"};
    return names.at(static_cast<std::size_t>(component));
}

/// The component that `type` means in a NRRD, MetaImage or VTK file; nothing if it is none.
std::optional<Component> component_named(const std::string& type);

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

}  // namespace pxpl5::host::io
