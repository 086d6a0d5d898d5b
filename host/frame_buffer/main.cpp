// pxpl5-framebuffer: the frame buffer of the machine, as a process.
#include <memory>

#include "host/frame_buffer/node.hpp"
#include "ringbus/process/kept_memory.hpp"
#include "ringbus/process/process.hpp"

int main(int argc, char** argv) {
    using namespace pxpl5;
    bus::keep_freed_memory(32 << 20, 32 << 20);
    return bus::run_process(argc, argv, bus::schema::Role::frame_buffer,
                            [] { return std::make_unique<host::FrameBufferNode>(); });
}
