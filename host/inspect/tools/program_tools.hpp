// pxpl5 asm and pxpl5 dis: text to words and back.
#pragma once

#include <string>
#include <vector>

namespace pxpl5::host::inspect {

struct AsmOptions {
    std::string file{},
        output{};  ///< To a file go binary words, to standard output hexadecimal text.
    std::vector<std::string> parameters{};  ///< "name=value".
    bool hex = false;                       ///< Hexadecimal text to a file, too.
};
int assemble_tool(const AsmOptions& options);

struct DisOptions {
    std::string file{}, output{};
    bool numbered = false, hex = false, binary = false;
};
int disassemble_tool(const DisOptions& options);

}  // namespace pxpl5::host::inspect
