// The text of `info` on every file of the data folder, held as a golden.
#include <doctest/doctest.h>

#include <cstdio>
#include <filesystem>
#include <set>

#include "tests/golden.hpp"
#include "tests/host/commands/info_text.hpp"

namespace fs = std::filesystem;

namespace {

const std::string data_folder = std::string(PXPL5_SOURCE_DIR) + "/../shared/data/";

/// Files, and folders of DICOM files as one, by name.
std::set<std::string> entries() {
    std::set<std::string> found;
    for (const auto& entry : fs::recursive_directory_iterator(data_folder)) {
        const fs::path parent = entry.path().parent_path();
        const bool is_of_series = parent.filename().string().ends_with("_dicom");
        if (entry.is_regular_file() && parent / "" != fs::path(data_folder)) {
            found.insert(is_of_series ? parent.string() : entry.path().string());
        }
    }
    return found;
}

}  // namespace

TEST_SUITE("host/commands/info_data") {
    TEST_CASE("info on every file of the data folder") {
        if (!fs::is_directory(data_folder)) {
            std::printf("SKIPPED: %s is absent\n", data_folder.c_str());
            return;
        }
        std::string all;
        for (const std::string& path : entries()) {
            all += pxpl5::test::info(path, data_folder);
        }
        pxpl5::test::check_golden("info_data.txt", all, "ctest --preset release -R host_info_data");
    }
}
