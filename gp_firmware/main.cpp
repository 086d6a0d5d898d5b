// pxpl5-gp: one Graphics Processor as a process.

#include <malloc.h>

#include <memory>

#include "gp_firmware/node.hpp"
#include "gp_firmware/node_trace.hpp"
#include "ringbus/process/process.hpp"

namespace {

/// Meshes grow and are made anew with every isovalue: given back to the system in between, their
/// pages cost up to a tenth of an extraction. Messages over tcp lie there, too.
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
