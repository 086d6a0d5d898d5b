// generate_isa_md FILE: writes ISA.md. Run by the target isa_doc.
#include <cstdio>
#include <fstream>

#include "isa/isa_md.hpp"

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fputs("usage: generate_isa_md FILE\n", stderr);
        return 64;
    }
    std::ofstream file(argv[1], std::ios::binary);
    file << pxpl5::isa::isa_markdown();
    file.close();
    if (!file) {
        std::fprintf(stderr, "generate_isa_md: cannot write %s\n", argv[1]);
        return 1;
    }
    return 0;
}
