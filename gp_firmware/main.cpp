// pxpl5-gp: one Graphics Processor as a process.

#include <memory>

#include "gp_firmware/node/copied_slices.hpp"
#include "gp_firmware/node/node.hpp"
#include "ringbus/process/kept_memory.hpp"
#include "ringbus/process/process.hpp"

int main(int argc, char** argv) {
    // Every isovalue makes new meshes; returning their pages to the system costs up to a tenth of
    // an extraction. They are returned when another volume comes (drop_content).
    constexpr int kept_bytes = 1 << 30;
    pxpl5::bus::keep_freed_memory(kept_bytes, kept_bytes);
    return pxpl5::bus::run_process(
        argc, argv, pxpl5::bus::schema::Role::gp,
        [] { return std::make_unique<pxpl5::gp::GpNode>(); }, pxpl5::gp::CopiedSlices{});
}
