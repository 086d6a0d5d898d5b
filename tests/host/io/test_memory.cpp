// How much memory a large volume takes while it is read.
#include <doctest/doctest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zlib.h>

#include <cstdio>
#include <functional>

#include "host/io/import.hpp"
#include "tests/host/io/volume_writers.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

constexpr int nx = 512, ny = 512, nz = 300;
constexpr std::size_t slice_values = std::size_t{nx} * ny;
constexpr double volume_mib = slice_values * nz * 2.0 / (1 << 20);
constexpr double most_volumes = 1.3;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool has_sanitizer = true;  // Whose own memory is larger than the volume.
#else
constexpr bool has_sanitizer = false;
#endif

/// A line of /proc/self/status, in MiB.
double status_mib(const std::string& key) {
    std::ifstream stream("/proc/self/status");
    for (std::string line; std::getline(stream, line);) {
        if (line.starts_with(key)) {
            return std::stod(line.substr(key.size() + 1)) / 1024;
        }
    }
    return 0;
}

/// Slice z: a ball in noise.
std::string slice_bytes(int z) {
    std::vector<std::int16_t> values(slice_values);
    unsigned noise = static_cast<unsigned>(z) + 1;
    for (std::size_t i = 0; i < slice_values; ++i) {
        const int x = static_cast<int>(i % nx) - 256, y = static_cast<int>(i / nx) - 256;
        noise = noise * 1664525U + 1013904223U;
        const bool inside = x * x + y * y + (z - 150) * (z - 150) < 140 * 140;
        values[i] =
            static_cast<std::int16_t>((inside ? 300 : -1000) + static_cast<int>(noise >> 28U));
    }
    return bytes_of(values);
}

const std::string nrrd_head =
    "NRRD0004\ntype: short\ndimension: 3\nspace: LPS\nsizes: 512 512 300\nendian: little\n"
    "space directions: (1,0,0) (0,1,0) (0,0,1)\nencoding: ";
const std::string meta_head =
    "NDims = 3\nDimSize = 512 512 300\nElementSpacing = 1 1 1\nElementType = MET_SHORT\n"
    "ElementDataFile = LOCAL\n";

void write_plain(const std::string& path, const std::string& head) {
    std::ofstream stream(path, std::ios::binary);
    stream << head;
    for (int z = 0; z < nz; ++z) {
        stream << slice_bytes(z);
    }
}

void write_gzip(const std::string& path, const std::string& plain_head, const std::string& head) {
    std::ofstream(path, std::ios::binary) << plain_head;
    gzFile file = gzopen(path.c_str(), "ab1");
    gzwrite(file, head.data(), static_cast<unsigned>(head.size()));
    for (int z = 0; z < nz; ++z) {
        const std::string slice = slice_bytes(z);
        gzwrite(file, slice.data(), static_cast<unsigned>(slice.size()));
    }
    gzclose(file);
}

std::string nifti_head() {
    Grid grid;
    grid.dims = {nx, ny, nz};
    return nifti1_header(grid).bytes();
}

void write_dicom(const std::string& folder) {
    std::filesystem::create_directory(folder);
    for (int z = 0; z < nz; ++z) {
        DicomSet set = dicom_image(nx, ny, slice_bytes(z));
        dicom_place(set, {0, 0, 1.0 * z}, {1, 0, 0}, {0, 1, 0}, 1, 1);
        std::ofstream(folder + "/" + std::to_string(z), std::ios::binary) << set.file();
    }
}

/// Imports in a child and says how many volumes of memory that took, above the idle process.
double volumes_taken(const std::string& path) {
    void* shared =
        mmap(nullptr, sizeof(double), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    REQUIRE(shared != MAP_FAILED);
    auto& volumes = *static_cast<double*>(shared);
    const pid_t child = fork();
    if (child == 0) {
        const double idle_mib = status_mib("VmRSS:");
        try {
            const Volume volume = import_volume(path);
            volumes = (status_mib("VmHWM:") - idle_mib) / volume_mib;
            _exit(volume.nz == nz && volume.type == Scalar::int16 ? 0 : 1);
        } catch (const ImportError&) {
            _exit(2);
        }
    }
    int status = 0;
    waitpid(child, &status, 0);
    CHECK(status == 0);
    const double taken = volumes;
    munmap(shared, sizeof(double));
    return taken;
}

}  // namespace

TEST_SUITE("host/io/memory") {
    TEST_CASE("512x512x300 of int16 take no more than 1.3 times their size, whatever the format" *
              doctest::skip(has_sanitizer)) {
        const TemporaryFolder folder;
        const std::string path = folder.file("v");
        const auto check = [&](const std::string& suffix, const auto& write) {
            write(path + suffix);
            const double taken = volumes_taken(path + suffix);
            std::printf("%-9s %.2f volumes of %.0f MiB\n", suffix.c_str(), taken, volume_mib);
            CHECK(taken >= 1);
            CHECK(taken <= most_volumes);
            std::filesystem::remove_all(path + suffix);
        };
        check(".nrrd", [](const std::string& to) { write_plain(to, nrrd_head + "raw\n\n"); });
        check(".gz.nrrd",
              [](const std::string& to) { write_gzip(to, nrrd_head + "gzip\n\n", ""); });
        check(".mha", [](const std::string& to) { write_plain(to, meta_head); });
        check(".z.mha", [](const std::string& to) {
            write_gzip(to, "CompressedData = True\n" + meta_head, "");
        });
        check(".nii", [](const std::string& to) { write_plain(to, nifti_head()); });
        check(".nii.gz", [](const std::string& to) { write_gzip(to, "", nifti_head()); });
        check(" folder", [](const std::string& to) { write_dicom(to); });
    }
}
