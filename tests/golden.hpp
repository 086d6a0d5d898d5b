// Golden files: the expected text of a test lives in tests/golden, and the test can rewrite it.
#pragma once

#include <doctest/doctest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

namespace pxpl5::test {

/// Compares `got` with tests/golden/<name>. With PXPL5_UPDATE_GOLDEN set it writes the file
/// instead.
///
/// rewrite   The command that rewrites this file, for the one who sees the test fail.
inline void check_golden(const std::string& name, const std::string& got,
                         const std::string& rewrite) {
    const std::string path = std::string(PXPL5_GOLDEN_DIR) + "/" + name;
    if (std::getenv("PXPL5_UPDATE_GOLDEN") != nullptr) {
        std::ofstream(path) << got;
        return;
    }
    std::ifstream file(path);
    const std::string want{std::istreambuf_iterator<char>(file), {}};
    CHECK_MESSAGE(got == want, path, " differs; after reading the difference, rewrite it with: ",
                  "PXPL5_UPDATE_GOLDEN=1 ", rewrite);
}

}  // namespace pxpl5::test
