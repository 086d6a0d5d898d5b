// The first view of every readable volume of the data folder.
#include <cstdio>
#include <filesystem>
#include <set>

#include "host/io/import.hpp"
#include "tests/host/commands/fit_check.hpp"

namespace fs = std::filesystem;

TEST_CASE("the first view of every file of the data folder shows its surfaces whole and large") {
    const fs::path data = fs::path(PXPL5_SOURCE_DIR) / "../shared/data";
    if (!fs::is_directory(data)) {
        std::printf("SKIPPED: %s is absent\n", data.c_str());
        return;
    }
    std::set<std::string> paths;
    for (const auto& entry : fs::recursive_directory_iterator(data)) {
        const fs::path parent = entry.path().parent_path();
        if (entry.is_regular_file()) {
            paths.insert(
                (parent.filename().string().ends_with("_dicom") ? parent : entry.path()).string());
        }
    }
    int seen = 0;
    for (const std::string& path : paths) {
        pxpl5::host::io::ImportRequest request;
        request.path = path;
        try {
            const pxpl5::host::Volume volume = pxpl5::host::io::import_volume(request);
            // A single slice has no surface.
            if (volume.nz > 1 && volume.minimum < volume.maximum) {
                pxpl5::test::check_first_view(volume, {"anterior"});
                ++seen;
            }
        } catch (const pxpl5::host::io::ImportError&) {
            continue;  // Broken on purpose, or not a volume.
        }
    }
    CHECK(seen > 15);
}
