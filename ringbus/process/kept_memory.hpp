// Memory that a process keeps when it is freed.
#pragma once

#include <malloc.h>

namespace pxpl5::bus {

/// Messages and pictures come and go with each frame. Returned to the system, their pages would be
/// mapped and cleared again for the next frame: up to 1.7 ms for each MB that arrives over tcp.
///
/// largest_bytes  Larger blocks, such as volumes, are returned when they are freed.
/// kept_bytes     The most freed memory that stays in the process, for each heap of the allocator.
inline void keep_freed_memory(int largest_bytes, int kept_bytes) {
#ifdef __GLIBC__
    constexpr int step_bytes = 1 << 20;  // A heap grows by this much, so rarely.
    mallopt(M_MMAP_THRESHOLD, largest_bytes);
    mallopt(M_TRIM_THRESHOLD, kept_bytes);
    mallopt(M_TOP_PAD, step_bytes);
#else
    static_cast<void>(largest_bytes);
    static_cast<void>(kept_bytes);
#endif
}

}  // namespace pxpl5::bus
