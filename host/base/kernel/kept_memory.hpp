// Memory that a process keeps when it is freed.
#pragma once

#include <malloc.h>

namespace pxpl5::host {

/// Pictures come and go with each frame. Returned to the system, their pages would be cleared again
/// for the next frame: 7 ms for two views of 1024 x 1024 pixels with depths. Larger blocks, such as
/// volumes, are returned when they are freed.
inline void keep_memory_of_pictures() {
#ifdef __GLIBC__
    constexpr int largest_bytes = 32 << 20, kept_bytes = 64 << 20;
    mallopt(M_MMAP_THRESHOLD, largest_bytes);
    mallopt(M_TRIM_THRESHOLD, kept_bytes);
#endif
}

}  // namespace pxpl5::host
