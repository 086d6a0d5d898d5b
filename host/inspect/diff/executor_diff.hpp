// Runs a region on two executors and finds the first instruction, pixel and bit that differ.
//
// Executors run ahead: many triangles as one step. So the whole parts of a region are compared
// first, as a Renderer runs them; then the part that differs is run in smaller and smaller pieces,
// down to one instruction. What differs only if run together is reported together.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "host/inspect/diff/pixel_state.hpp"
#include "host/inspect/record/region_walk.hpp"

namespace pxpl5::host::inspect {

/// A new executor, cleared and disabled.
using MakeExecutor = std::function<std::unique_ptr<isa::Executor>()>;

struct Divergence {
    Address address;                      ///< Address of the first instruction of the piece.
    std::size_t instructions = 1;         ///< Length of the piece, which differs only as a whole.
    StateBit bit;                         ///< The first after the piece.
    std::uint64_t first = 0, second = 0;  ///< Values of what holds the bit.
};

/// Nothing if both executors leave the same after every part.
std::optional<Divergence> first_divergence(const renderer::RegionPlan& plan,
                                           const MakeExecutor& make_first,
                                           const MakeExecutor& make_second);

}  // namespace pxpl5::host::inspect
