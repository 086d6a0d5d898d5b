#include <doctest/doctest.h>

#include <fstream>
#include <sstream>

#include "isa/isa_md.hpp"

TEST_CASE("ISA.md is what the rows say, and cmake --build BUILD --target isa_doc rewrites it") {
    std::ifstream file(PXPL5_SOURCE_DIR "/isa/ISA.md", std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    CHECK_MESSAGE(text.str() == pxpl5::isa::isa_markdown(),
                  "isa/ISA.md is stale: run  cmake --build BUILD --target isa_doc");
}
