#include "gp_firmware/hal/local_memory.hpp"

#include <cassert>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace pxpl5::gp {

namespace {

std::string message(const std::string& what_for, std::size_t needed, std::size_t available,
                    const std::string& advice) {
    std::string text = what_for + ": needs " + std::to_string(needed) + " bytes of local memory, " +
                       std::to_string(available) + " are free";
    return advice.empty() ? text : text + "; " + advice;
}

}  // namespace

OutOfLocalMemory::OutOfLocalMemory(const std::string& what_for, std::size_t needed,
                                   std::size_t available, const std::string& advice)
    : std::runtime_error(message(what_for, needed, available, advice)),
      needed_bytes(needed),
      available_bytes(available) {}

void LocalMemory::charge(std::size_t bytes, const std::string& what_for,
                         const std::string& advice) {
    if (bytes > available_bytes()) {
        throw OutOfLocalMemory(what_for, bytes, available_bytes(), advice);
    }
    used_bytes_ += bytes;
}

void LocalMemory::release(std::size_t bytes) {
    assert(bytes <= used_bytes_);
    used_bytes_ -= bytes;
}

void return_freed_memory() {
#ifdef __GLIBC__
    malloc_trim(0);
#endif
}

}  // namespace pxpl5::gp
