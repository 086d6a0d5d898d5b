// Which pxpl5 this is.
#pragma once

namespace pxpl5::host {

inline constexpr const char* version = PXPL5_VERSION;

/// "pxpl5 0.1.0".
inline constexpr const char* version_line() {
    return "pxpl5 " PXPL5_VERSION;
}

}  // namespace pxpl5::host
