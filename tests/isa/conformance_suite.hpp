// Reads the conformance cases and runs the reference executor through them.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "isa/conformance/conformance_run.hpp"
#include "isa/reference/reference.hpp"

namespace pxpl5::test {

/// A case and its file.
struct ConformanceFile {
    std::string name;  ///< "by_hand/NAME.pxt" or "generated/NAME.pxt".
    isa::ConformanceCase test;

    bool names(isa::Op op) const {
        const std::vector<std::uint32_t>& words = test.program.words;
        for (std::size_t at = 0; at < words.size(); at += isa::instruction_words(words[at])) {
            if (isa::decode(words[at])->op == op) {
                return true;
            }
        }
        return false;
    }
};

/// Appends the cases of `folder`. Throws std::runtime_error that names a file that is not a case.
inline void add_cases(const std::filesystem::path& folder, std::vector<ConformanceFile>& files) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        if (entry.path().extension() != ".pxt") {
            continue;
        }
        std::ostringstream text;
        text << std::ifstream(entry.path(), std::ios::binary).rdbuf();
        const std::string name = (folder.filename() / entry.path().filename()).string();
        try {
            files.push_back({name, isa::parse_conformance(text.str())});
        } catch (const isa::ConformanceError& error) {
            throw std::runtime_error(name + ": " + error.what());
        }
    }
}

/// All cases, sorted by name: those of the tree, and those that the build generates.
/// Throws std::runtime_error that names a file that is not a case.
inline const std::vector<ConformanceFile>& conformance_suite() {
    static const std::vector<ConformanceFile> suite = [] {
        std::vector<ConformanceFile> files;
        add_cases(PXPL5_SOURCE_DIR "/tests/isa/conformance/by_hand", files);
        add_cases(PXPL5_GENERATED_CASES, files);
        std::ranges::sort(files, {}, &ConformanceFile::name);
        return files;
    }();
    return suite;
}

/// Returns the first difference on the reference. Emulates the watched pixels, one rectangle at a
/// time. A program with ANYENAB needs the whole region.
inline std::string difference_on_reference(const ConformanceFile& file) {
    std::vector<isa::PixelRectangle> windows = isa::compared_pixels(file.test);
    if (file.names(isa::Op::any_enab)) {
        windows = {isa::PixelRectangle{}};
    }
    for (const isa::PixelRectangle& r : windows) {
        isa::reference::Reference reference({r.x0, r.y0, r.x1 - r.x0 + 1, r.y1 - r.y0 + 1});
        if (std::string found = first_difference(file.test, reference, r); !found.empty()) {
            return found;
        }
    }
    return {};
}

}  // namespace pxpl5::test
