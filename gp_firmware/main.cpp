// pxpl5-gp: one Graphics Processor as a process.

#include <malloc.h>

#include <memory>

#include "gp_firmware/node/copied_slices.hpp"
#include "gp_firmware/node/node.hpp"
#include "ringbus/process/process.hpp"

namespace {

/// Keeps freed memory in the process until another volume comes (drop_content). Every isovalue
/// makes new meshes; returning their pages to the system costs up to a tenth of an extraction.
/// Messages over tcp use this memory, too.
void keep_freed_memory() {
#ifdef __GLIBC__
    constexpr int kept_bytes = 1 << 30;
    mallopt(M_MMAP_THRESHOLD, kept_bytes);
    mallopt(M_TRIM_THRESHOLD, kept_bytes);
#endif
}

}  // namespace

int main(int argc, char** argv) {
    keep_freed_memory();
    return pxpl5::bus::run_process(
        argc, argv, pxpl5::bus::schema::Role::gp,
        [] { return std::make_unique<pxpl5::gp::GpNode>(); }, pxpl5::gp::CopiedSlices{});
}
