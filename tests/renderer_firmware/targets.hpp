// Runs a check on every vector target of this computer.
#pragma once

#include <doctest/doctest.h>

#include <string>

#include "renderer_firmware/fast/fast.hpp"

namespace pxpl5::test {

/// Calls check(fast executor) once per target, with a new executor.
template <typename Check>
void on_every_target(const Check& check) {
    for (const renderer::fast::Target target : isa::available_targets()) {
        CAPTURE(std::string(enum_name(target)));
        renderer::fast::Fast fast(target);
        check(fast);
    }
}

}  // namespace pxpl5::test
