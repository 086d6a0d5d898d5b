// Files of a test, and selections as a command line gives them.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "host/inspect/record/selection.hpp"

namespace pxpl5::test {

/// A folder that goes with the test.
struct Folder {
    Folder() {
        std::string name = (std::filesystem::temp_directory_path() / "pxpl5-test-XXXXXX").string();
        path = mkdtemp(name.data());
    }
    ~Folder() { std::filesystem::remove_all(path); }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    std::string at(const std::string& name) const { return (path / name).string(); }
    std::string write(const std::string& name, const std::string& text) const {
        std::ofstream(at(name), std::ios::binary) << text;
        return at(name);
    }
    std::filesystem::path path;
};

inline std::string content_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// An option of the selection, and what is given for it.
using Wanted =
    std::pair<std::vector<std::string> host::inspect::SelectionText::*, std::vector<std::string>>;

inline host::inspect::Selection selecting(const std::vector<Wanted>& wanted) {
    host::inspect::SelectionText text;
    for (const auto& [option, values] : wanted) {
        text.*option = values;
    }
    return host::inspect::parse_selection(text);
}

}  // namespace pxpl5::test
