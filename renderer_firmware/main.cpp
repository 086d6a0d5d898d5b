// pxpl5-renderer: the process of one Renderer.
#include <memory>

#include "renderer_firmware/node.hpp"
#include "ringbus/process/kept_memory.hpp"
#include "ringbus/process/process.hpp"

int main(int argc, char** argv) {
    using namespace pxpl5;
    bus::keep_freed_memory(32 << 20, 32 << 20);
    return bus::run_process(argc, argv, bus::schema::Role::renderer,
                            [] { return std::make_unique<renderer::RendererNode>(); });
}
