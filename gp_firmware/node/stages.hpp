// The stages of a GP's work that StageClock times.
#pragma once

#include <string_view>

#include "ringbus/stage_clock.hpp"

/// The stages of every node, and those of a GP.
namespace pxpl5::gp::stage {

using namespace bus::stage;
inline constexpr std::string_view load = "load";  ///< Storing slices and gradients, or scene parts.
inline constexpr std::string_view extract = "extract";
inline constexpr std::string_view simplify = "simplify";  ///< Blocks with less detail.
inline constexpr std::string_view measure = "measure";
inline constexpr std::string_view assign = "assign";        ///< Regions to Renderers; only GP 0.
inline constexpr std::string_view transform = "transform";  ///< Vertices to the screen.
inline constexpr std::string_view select = "select";        ///< Culling, clipping, binning.
inline constexpr std::string_view set_up = "set_up";        ///< Planes and instruction words.

}  // namespace pxpl5::gp::stage
