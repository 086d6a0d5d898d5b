// A file that GPs read: the scan finds what the import finds, and the GPs read the same voxels.
#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "gp_firmware/volume/stored_slices.hpp"
#include "host/base/digest.hpp"
#include "host/io/formats/stored_header.hpp"
#include "host/volume/reduced.hpp"
#include "tests/host/io/formats/gp_shape.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;
namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t all_bytes = std::uint64_t{1} << 30;

struct Scratch {
    Scratch() {
        std::string pattern = fs::temp_directory_path() / "pxpl5-test-XXXXXX";
        REQUIRE(mkdtemp(pattern.data()) != nullptr);
        folder = pattern;
    }
    ~Scratch() { fs::remove_all(folder); }
    fs::path folder;
};

/// A raw file of 5 x 4 x 6 values that climb from the type's least to its greatest, after a head.
StoredHeader written(const fs::path& path, Component component, bool big_endian, Scale scale) {
    constexpr std::size_t count = 5 * 4 * 6;
    std::string bytes = "a head of 21 bytes...";
    with_type(component, [&]<typename T>(T*) {
        for (std::size_t i = 0; i < count; ++i) {
            const double share = 0.9 * static_cast<double>(i) / (count - 1);
            T value{};
            if constexpr (std::is_integral_v<T>) {
                value = static_cast<T>(static_cast<double>(std::numeric_limits<T>::min()) / 2 +
                                       static_cast<double>(std::numeric_limits<T>::max()) * share);
            } else {
                value = i == 17 ? std::numeric_limits<T>::quiet_NaN()
                                : static_cast<T>(std::sin(share * 40) * 700.3);
            }
            std::string one(sizeof value, '\0');
            std::memcpy(one.data(), &value, sizeof value);
            bytes += big_endian ? std::string(one.rbegin(), one.rend()) : one;
        }
    });
    std::ofstream(path, std::ios::binary) << bytes << "and a tail";
    StoredHeader header;
    header.sizes = {5, 4, 6};
    header.type = component_name(component);
    header.component = component;
    header.big_endian = big_endian;
    header.data_files = {path};
    header.byte_skip = 21;
    header.scale = scale;
    return header;
}

const std::vector<Scale> scales = {{1, 0}, {0.37, -12.5}, {1, -1024}, {2, 0}};

}  // namespace

TEST_CASE("the scan finds type, range, values and findings of the import, for every stored type") {
    const Scratch scratch;
    const fs::path path = scratch.folder / "values.raw";
    for (int type = 0; type <= static_cast<int>(Component::float64); ++type) {
        for (const bool big_endian : {false, true}) {
            for (const Scale& scale : scales) {
                const StoredHeader header =
                    written(path, static_cast<Component>(type), big_endian, scale);
                CAPTURE(header.type);
                CAPTURE(big_endian);
                CAPTURE(scale.slope);
                CAPTURE(scale.intercept);
                const Volume whole = StoredReader().read(path, header);
                const Volume scanned = scan_stored_values(path, header, all_bytes);
                CHECK(scanned.type == whole.type);
                CHECK(scanned.minimum == whole.minimum);
                CHECK(scanned.maximum == whole.maximum);
                CHECK(scanned.values == whole.values);
                CHECK(scanned.reduction == 1);
                Digest digest;
                digest.add(whole.values);
                CHECK(scanned.digest == digest.value());
                std::vector<Finding> findings = scanned.findings;
                REQUIRE(!findings.empty());
                findings.pop_back();  // The last one is about the GPs.
                CHECK(findings == whole.findings);

                REQUIRE(scanned.stored);
                gp::StoredSlices slices(shape_of(scanned), *scanned.stored);
                const std::size_t bytes = whole.values.size() / 6;
                for (const int z : {5, 0, 3}) {
                    const auto slice = slices.read(z);
                    REQUIRE(slice.size() == bytes);
                    CHECK(std::memcmp(slice.data(),
                                      whole.values.data() + static_cast<std::size_t>(z) * bytes,
                                      bytes) == 0);
                }
            }
        }
    }
}

TEST_CASE("the reduced copy has every n-th voxel, and the least n with which it fits") {
    const Scratch scratch;
    const fs::path path = scratch.folder / "values.raw";
    const StoredHeader header = written(path, Component::int16, false, {});
    const Volume whole = StoredReader().read(path, header);
    const Volume scanned = scan_stored_values(path, header, 2 * 2 * 2 * 2);
    CHECK(scanned.reduction == 3);
    CHECK(scanned.values.empty());
    REQUIRE(scanned.reduced);
    const Volume& copy = *scanned.reduced;
    CHECK(copy.nx == 2);
    CHECK(copy.ny == 2);
    CHECK(copy.nz == 2);
    REQUIRE(copy.values.size() == 16);
    for (std::size_t i = 0; i < 8; ++i) {
        const std::size_t x = i % 2 * 3, y = i / 2 % 2 * 3, z = i / 4 * 3;
        CHECK(std::memcmp(copy.values.data() + 2 * i,
                          whole.values.data() + 2 * ((z * 4 + y) * 5 + x), 2) == 0);
    }
    CHECK(scan_stored_values(path, header, 2 * 2 * 2 * 2 - 1).reduction == 4);
    CHECK(scan_stored_values(path, header, 240).reduction == 1);
    CHECK(scan_stored_values(path, header, 239).reduction == 2);
}

TEST_CASE("a file that a GP finds changed is refused with the file, both values and the remedy") {
    const Scratch scratch;
    const fs::path path = scratch.folder / "values.raw";
    const StoredHeader header = written(path, Component::uint8, false, {});
    const Volume scanned = scan_stored_values(path, header, all_bytes);
    const auto error = [&](SlicesFile file) {
        try {
            gp::StoredSlices(shape_of(scanned), StoredVolume{Component::uint8, false, 0, {file}})
                .read(0);
        } catch (const gp::StoredFileError& refusal) {
            return std::string(refusal.what());
        }
        return std::string("none");
    };
    SlicesFile file = scanned.stored->files[0];
    CHECK(error(file) == "none");
    file.facts.size_bytes = 7;
    CHECK(error(file).find(path.string() +
                           ": its size in bytes is 151 here, but was 7 when the host "
                           "loaded the volume. All computers must see") == 0);
    CHECK(error(file).ends_with("Load it again, or with read=host"));
    file.facts.size_bytes = max_volume_bytes + 1;
    CHECK(error(file).ends_with("Load it again"));
    file = scanned.stored->files[0];
    ++file.facts.inode;
    CHECK(error(file).find("its inode is") != std::string::npos);
    file = scanned.stored->files[0];
    --file.facts.modified_ns;
    CHECK(error(file).find("the time of its last change in ns is") != std::string::npos);
    file.path = scratch.folder;
    CHECK(error(file).find("is no regular file") != std::string::npos);
    file.path = scratch.folder / "absent.raw";
    CHECK(error(file).find("cannot be opened: No such file or directory") != std::string::npos);

    gp::StoredSlices slices(shape_of(scanned), *scanned.stored);
    slices.read(0);
    std::ofstream(path, std::ios::app) << "more";
    CHECK_THROWS_AS(slices.check(), gp::StoredFileError);
    fs::resize_file(path, 30);
    CHECK_THROWS_AS(slices.read(5), gp::StoredFileError);
}

TEST_CASE("a value that does not fit into the type of the voxels is no voxel") {
    const Scratch scratch;
    const fs::path path = scratch.folder / "values.raw";
    const StoredHeader header = written(path, Component::int32, false, {});
    Volume scanned = scan_stored_values(path, header, all_bytes);
    CHECK(scanned.type == Scalar::float32);
    gp::VolumeShape shape = shape_of(scanned);
    shape.type = Scalar::int16;
    gp::StoredSlices slices(shape, *scanned.stored);
    std::string error;
    try {
        slices.read(5);
    } catch (const gp::StoredFileError& refusal) {
        error = refusal.what();
    }
    CHECK(error.find("slice 5 has the value ") != std::string::npos);
    CHECK(error.find("int16 voxels have -32768 to 32767") != std::string::npos);
}

TEST_CASE("values in several files have the same bits, if each has whole slices") {
    const Scratch scratch;
    const fs::path path = scratch.folder / "values.raw";
    StoredHeader header = written(path, Component::int16, true, {0.5, 3});
    const Volume whole = StoredReader().read(path, header);
    header.data_files.clear();
    for (const int part : {0, 1, 2}) {
        const fs::path file = scratch.folder / ("part" + std::to_string(part));
        std::string bytes(2 * 5 * 4 * 2, '\0');
        std::ifstream(path, std::ios::binary)
            .seekg(21 + part * static_cast<std::streamoff>(bytes.size()))
            .read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        std::ofstream(file, std::ios::binary) << std::string(21, '?') + bytes;
        header.data_files.push_back(file);
    }
    CHECK(why_not_by_gps(header).empty());
    const Volume scanned = scan_stored_values(path, header, all_bytes);
    REQUIRE(scanned.stored);
    CHECK(scanned.stored->files.size() == 3);
    CHECK(scanned.values == whole.values);
    gp::StoredSlices slices(shape_of(scanned), *scanned.stored);
    const std::size_t bytes = whole.values.size() / 6;
    for (const int z : {5, 0, 1, 2, 4, 3}) {
        const auto slice = slices.read(z);
        CHECK(std::equal(slice.begin(), slice.end(),
                         whole.values.begin() + static_cast<std::ptrdiff_t>(bytes) * z));
    }
    header.data_files.push_back(path);
    CHECK(why_not_by_gps(header) == "its 4 files do not have whole slices, of which there are 6");
}
