// Tests real series that were renamed, incomplete, doubled, mixed or cut.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <numeric>
#include <random>

#include "host/io/import.hpp"
#include "tests/host/io/volume_files.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

namespace fs = std::filesystem;

const std::string knee = std::string(PXPL5_SOURCE_DIR) + "/../shared/data/ct/knee_dicom";
const std::string tilted =
    std::string(PXPL5_SOURCE_DIR) + "/../shared/data/ct/phantom_head_tilt_dicom";

bool has_data() {
    if (fs::is_directory(knee)) {
        return true;
    }
    std::printf("SKIPPED: %s is absent\n", knee.c_str());
    return false;
}

std::vector<fs::path> files_of(const std::string& folder) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder)) {
        files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    return files;
}

void copy_all(const std::string& from, const TemporaryFolder& to) {
    for (const fs::path& file : files_of(from)) {
        fs::copy_file(file, to.file(file.filename()));
    }
}

bool reports(const Volume& volume, FindingKind kind, const std::string& words) {
    return std::any_of(volume.findings.begin(), volume.findings.end(), [&](const Finding& f) {
        return f.kind == kind && f.text.find(words) != std::string::npos;
    });
}

}  // namespace

TEST_SUITE("host/io/data_derived") {
    TEST_CASE("the knee's files under random names are the same knee") {
        if (!has_data()) {
            return;
        }
        const TemporaryFolder folder;
        const std::vector<fs::path> files = files_of(knee);
        std::vector<std::size_t> names(files.size());
        std::iota(names.begin(), names.end(), std::size_t{0});
        std::shuffle(names.begin(), names.end(), std::mt19937(5));
        for (std::size_t i = 0; i < files.size(); ++i) {
            fs::copy_file(files[i], folder.file("x" + std::to_string(names[i])));
        }
        const Volume whole = import_volume(knee), renamed = import_volume(folder.file(""));
        CHECK(renamed.values == whole.values);
        CHECK(renamed.voxel_to_patient == whole.voxel_to_patient);
    }

    TEST_CASE("a knee without one slice has a gap of 6.54 mm, and every other slice in its place") {
        if (!has_data()) {
            return;
        }
        const TemporaryFolder folder;
        copy_all(knee, folder);
        fs::remove(folder.file("000010.dcm"));
        const Volume volume = import_volume(folder.file(""));
        CHECK(volume.nz == 48);
        REQUIRE(volume.slice_places.size() == 48);
        REQUIRE(volume.gap_slabs.size() == 1);
        const auto gap = static_cast<std::size_t>(volume.gap_slabs[0]);
        CHECK(volume.slice_places[gap + 1] - volume.slice_places[gap] ==
              doctest::Approx(2).epsilon(1e-6));
        CHECK(volume.slice_places.back() == doctest::Approx(48).epsilon(1e-6));
        CHECK(reports(volume, FindingKind::missing_slices, "6.540 mm from 0000"));
        CHECK(volume.voxel_to_patient[2].z == doctest::Approx(3.27));
    }

    TEST_CASE("a knee with one slice twice is the knee, and the copy is reported") {
        if (!has_data()) {
            return;
        }
        const TemporaryFolder folder;
        copy_all(knee, folder);
        fs::copy_file(knee + "/000010.dcm", folder.file("zz.dcm"));
        const Volume volume = import_volume(folder.file(""));
        CHECK(volume.values == import_volume(knee).values);
        CHECK(reports(volume, FindingKind::note,
                      "1 copy of a slice is left out: zz.dcm has the image of 000010.dcm"));
    }

    TEST_CASE("knee and head in one folder are listed, and either can be chosen") {
        if (!has_data()) {
            return;
        }
        const TemporaryFolder folder;
        copy_all(knee, folder);
        copy_all(tilted, folder);
        ImportRequest request;
        request.path = folder.file("");
        CHECK_THROWS_WITH_AS(import_volume(request), doctest::Contains("134x162x49"), ImportError);
        CHECK_THROWS_WITH_AS(import_volume(request), doctest::Contains("128x128x58"), ImportError);
        std::vector<std::size_t> sizes;
        for (const char* number : {"1", "2"}) {
            request.series = number;
            const Volume volume = import_volume(request);
            sizes.push_back(static_cast<std::size_t>(volume.nz));
            CHECK(reports(volume, FindingKind::other_series, "is left out"));
        }
        std::sort(sizes.begin(), sizes.end());
        CHECK(sizes == std::vector<std::size_t>{49, 58});
    }

    TEST_CASE("a knee without a file that is cut has a gap, and a finding that names the file") {
        if (!has_data()) {
            return;
        }
        const TemporaryFolder folder;
        copy_all(knee, folder);
        const std::string cut = folder.file("000020.dcm");
        fs::permissions(cut, fs::perms::owner_all);
        fs::resize_file(cut, fs::file_size(cut) - 100);
        const Volume volume = import_volume(folder.file(""));
        CHECK(volume.nz == 48);
        CHECK(volume.gap_slabs.size() == 1);
        CHECK(reports(volume, FindingKind::missing_slices,
                      "000020.dcm: pixel data (7fe0,0010) have 43316 bytes, 134x162x1 of 2 bytes "
                      "need 43416: this file is left out"));
    }
}
