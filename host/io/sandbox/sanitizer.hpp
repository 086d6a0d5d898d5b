// Whether this build has a sanitizer, which itself needs memory, files and processes.
#pragma once

namespace pxpl5::host::io {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool has_sanitizer = true;
#else
inline constexpr bool has_sanitizer = false;
#endif

}  // namespace pxpl5::host::io
