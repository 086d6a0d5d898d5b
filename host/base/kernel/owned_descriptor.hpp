// A file descriptor that is closed at the end of its life.
#pragma once

#include <unistd.h>

namespace pxpl5::host {

struct OwnedDescriptor {
    int fd;  ///< Negative: none.

    explicit OwnedDescriptor(int opened) : fd(opened) {}
    ~OwnedDescriptor() {
        if (fd >= 0) {
            close(fd);
        }
    }
    OwnedDescriptor(const OwnedDescriptor&) = delete;
    OwnedDescriptor& operator=(const OwnedDescriptor&) = delete;
};

}  // namespace pxpl5::host
