// Gives files to a fuzz target, without libFuzzer: replay FILE...
#include <exception>
#include <fstream>
#include <iterator>
#include <vector>

#include "tests/fuzz/fuzz.hpp"

namespace {

std::vector<std::uint8_t> content_of(const char* path) {
    std::ifstream file(path, std::ios::binary);
    pxpl5::fuzz::require(file.is_open(), std::string(path) + " cannot be read");
    return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

/// Fails if the target accepts none of the files: such a corpus reaches nothing.
int main(int argc, char** argv) {
    int accepted = 0;
    for (int i = 1; i < argc; ++i) {
        std::printf("%s\n", argv[i]);
        std::fflush(stdout);
        accepted += pxpl5::fuzz::accepts(content_of(argv[i])) ? 1 : 0;
    }
    std::printf("%d of %d inputs accepted\n", accepted, argc - 1);
    return accepted > 0 ? 0 : 1;
}
