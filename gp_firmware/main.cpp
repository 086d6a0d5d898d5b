// pxpl5-gp: one Graphics Processor as a process.

#include <memory>

#include "gp_firmware/node.hpp"
#include "ringbus/process.hpp"

int main(int argc, char** argv) {
    return pxpl5::bus::run_process(argc, argv, pxpl5::bus::schema::Role::gp,
                                   [] { return std::make_unique<pxpl5::gp::GpNode>(); });
}
