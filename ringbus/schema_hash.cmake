# Writes a header with a hash over the texts of FILES, for Hello.
set(text "")
foreach(file ${FILES})
    file(READ ${file} content)
    string(APPEND text "${content}")
endforeach()
string(SHA256 hash "${text}")
string(SUBSTRING "${hash}" 0 16 hash)
file(WRITE ${OUTPUT}
    "// Generated from the schema files.\n#pragma once\n\n#include <cstdint>\n\n"
    "namespace pxpl5::bus {\n"
    "inline constexpr std::uint64_t generated_schema_hash = 0x${hash}U;\n"
    "}\n")
