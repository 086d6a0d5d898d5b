// pxpl5-renderer: one Renderer of the machine, as a process.
#include <memory>

#include "renderer_firmware/node.hpp"
#include "ringbus/process.hpp"

int main(int argc, char** argv) {
    using namespace pxpl5;
    return bus::run_process(argc, argv, bus::schema::Role::renderer,
                            [] { return std::make_unique<renderer::RendererNode>(); });
}
