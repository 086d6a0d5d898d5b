// The region programs' texts, assembled: programs/NAME.pxasm is programs::NAME.
#pragma once

#include "renderer_firmware/programs/text.hpp"

namespace pxpl5::renderer::programs {

// Made by assemble_texts.cpp.
#include "program_words.inc"

}  // namespace pxpl5::renderer::programs
