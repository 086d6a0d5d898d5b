// MGH and MGZ files of FreeSurfer.
#include <doctest/doctest.h>

#include <algorithm>

#include "host/io/import.hpp"
#include "tests/host/io/volume_writers.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

Grid small_grid() {
    Grid grid{{4, 3, 2}, glm::dmat4(1.0), ramp<std::int16_t>(24)};
    for (int axis = 0; axis < 3; ++axis) {
        grid.affine[axis] *= axis + 1;
    }
    grid.affine[3] = {10, -20, 30, 1};
    return grid;
}

std::string changed(std::size_t offset, const std::string& field) {
    return mgh_file(small_grid()).replace(offset, field.size(), field);
}

std::string refusal(const std::string& path) {
    try {
        import_volume(path);
        return "none";
    } catch (const ImportError& error) {
        const std::string text = error.what();
        return text.substr(text.find(": ") + 2);
    }
}

}  // namespace

TEST_SUITE("host/io/mgh") {
    TEST_CASE("values and place, compressed or not, and with tags behind the values") {
        const TemporaryFolder folder;
        const std::string file = mgh_file(small_grid());
        for (const std::string& path :
             {folder.write("v.mgh", file), folder.write("v.MGH", file + "tags of any length"),
              folder.write("v.mgz", gzipped(folder, file + "tags")),
              folder.write("v.mgh.gz", gzipped(folder, file))}) {
            CAPTURE(path);
            const Volume volume = import_volume(path);
            CHECK(volume.name == "v");
            CHECK(std::array{volume.nx, volume.ny, volume.nz} == std::array{4, 3, 2});
            REQUIRE(volume.type == Scalar::int16);
            CHECK(std::memcmp(volume.values.data(), small_grid().values.data(), 48) == 0);
            CHECK(volume.voxel_to_patient == small_grid().affine);
            CHECK(volume.findings.empty());
        }
    }

    TEST_CASE("each type of value") {
        const TemporaryFolder folder;
        const std::string head = mgh_file(small_grid()).substr(0, 284);
        const auto read = [&](std::int32_t code, const std::string& values) {
            std::string bytes = head;
            bytes.replace(20, 4, bytes_of(code, true));
            return import_volume(folder.write("v.mgh", bytes + values));
        };
        CHECK(read(0, std::string(24, '\xff')).maximum == 255);
        CHECK(read(1, bytes_of(std::vector<std::int32_t>(24, -70'000), true)).minimum == -70'000);
        CHECK(read(3, bytes_of(std::vector<float>(24, 0.25F), true)).minimum == 0.25);
        CHECK(read(4, bytes_of(std::vector<std::int16_t>(24, -2), true)).minimum == -2);
        CHECK(read(10, bytes_of(std::vector<std::uint16_t>(24, 65'535), true)).maximum == 65'535);
    }

    TEST_CASE("without a place, FreeSurfer's coronal slices are assumed, and said") {
        const TemporaryFolder folder;
        const Volume volume = import_volume(folder.write("v.mgh", changed(28, {"\0\0", 2})));
        CHECK(glm::dvec3(volume.voxel_to_patient[3]) == glm::dvec3(0, 0, 0));
        CHECK(glm::dvec3(volume.voxel_to_patient[0]) == glm::dvec3(1, 0, 0));
        CHECK(glm::dvec3(volume.voxel_to_patient[1]) == glm::dvec3(0, 0, -1));
        CHECK(glm::dvec3(volume.voxel_to_patient[2]) == glm::dvec3(0, -1, 0));
        CHECK(std::ranges::any_of(volume.findings, [](const Finding& finding) {
            return finding.kind == FindingKind::assumption &&
                   finding.text.find("goodRASFlag is 0") != std::string::npos;
        }));
        ImportRequest request;
        request.path = folder.file("v.mgh");
        request.spacing_mm = glm::dvec3(1, 2, 3);
        CHECK(glm::dvec3(import_volume(request).voxel_to_patient[1]) == glm::dvec3(0, 0, -2));
    }

    TEST_CASE("broken headers are refused, with the field and its value") {
        const TemporaryFolder folder;
        const auto with = [&](std::size_t offset, std::int32_t value) {
            return refusal(folder.write("v.mgh", changed(offset, bytes_of(value, true))));
        };
        CHECK(with(0, 2) == "version is 2, must be 1");
        CHECK(with(8, -1) == "height is -1, must be 1 or more");
        CHECK(with(16, 0) == "nframes is 0, must be 1 or more");
        CHECK(with(20, 2) ==
              "type is 2, must be 0 (uchar), 1 (int), 3 (float), 4 (short) or 10 (ushort)");
        CHECK(with(4, 5000) == "5000 voxels along x, must be 2 to 4096");
        CHECK(with(4, 40) == "40x3x2 of int16 need 480 bytes, v.mgh has 48");
        CHECK(refusal(folder.write("cut.mgh", mgh_file(small_grid()).substr(0, 100))) ==
              "its header needs 284 bytes, 100 could be read");
    }
}
