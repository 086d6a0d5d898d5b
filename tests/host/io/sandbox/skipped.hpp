// Tests of the sandbox that cannot run here say so.
#pragma once

#include <doctest/doctest.h>

#include "host/base/kernel/protections.hpp"
#include "host/io/sandbox/sanitizer.hpp"

namespace pxpl5::test {

/// A test returns if one of these is true.
inline bool lacks_sandbox() {
    if (host::io::has_sanitizer) {
        MESSAGE("SKIPPED: a build with a sanitizer has no sandbox");
    }
    return host::io::has_sanitizer;
}

inline bool lacks_landlock() {
    if (host::landlock_version() == 0) {
        MESSAGE("SKIPPED: this kernel has no Landlock");
    }
    return lacks_sandbox() || host::landlock_version() == 0;
}

inline bool lacks_filters() {
    if (!host::has_system_call_filters()) {
        MESSAGE("SKIPPED: this kernel has no seccomp filters");
    }
    return lacks_sandbox() || !host::has_system_call_filters();
}

}  // namespace pxpl5::test
