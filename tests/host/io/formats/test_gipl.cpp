// GIPL files, and raw files that are compressed.
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

std::string refusal(const ImportRequest& request) {
    try {
        import_volume(request);
        return "none";
    } catch (const ImportError& error) {
        const std::string text = error.what();
        return text.substr(text.find(": ") + 2);
    }
}

ImportRequest request_of(const std::string& path) {
    ImportRequest request;
    request.path = path;
    return request;
}

}  // namespace

TEST_SUITE("host/io/gipl") {
    TEST_CASE("values, spacing and origin, compressed or not") {
        const TemporaryFolder folder;
        std::string slice = gipl_file(small_grid());
        slice.replace(6, 2, std::string(2, '\0'));  // As writers of one volume leave it.
        for (const std::string& path :
             {folder.write("v.gipl", gipl_file(small_grid())), folder.write("w.gipl", slice),
              folder.write("v.gipl.gz", gzipped(folder, gipl_file(small_grid())))}) {
            CAPTURE(path);
            const Volume volume = import_volume(path);
            REQUIRE(volume.type == Scalar::int16);
            CHECK(std::memcmp(volume.values.data(), small_grid().values.data(), 48) == 0);
            CHECK(volume.voxel_to_patient == small_grid().affine);
            REQUIRE(volume.findings.size() == 1);
            CHECK(volume.findings[0].kind == FindingKind::assumption);
            CHECK(volume.findings[0].text.find("GIPL files have no agreed orientation") == 0);
        }
    }

    TEST_CASE("broken headers are refused, with the field and its value") {
        const TemporaryFolder folder;
        const auto with = [&](std::size_t offset, const std::string& field) {
            std::string bytes = gipl_file(small_grid());
            return refusal(
                request_of(folder.write("v.gipl", bytes.replace(offset, field.size(), field))));
        };
        CHECK(with(252, std::string(4, '\0')) ==
              "its magic number is 0, must be 719555000 or 4026526128");
        CHECK(with(8, bytes_of(std::uint16_t{66}, true)) ==
              "its image type is 66, must be one of the scalar types 1, 7, 8, 15, 16, 31, 32, 64, "
              "65");
        CHECK(with(14, bytes_of(-2.0F, true)) == "its spacing along y is -2, must be above 0 mm");
        CHECK(with(0, bytes_of(std::uint16_t{9}, true)) ==
              "9x3x2 of int16 need 108 bytes, v.gipl has 48");
    }
}

TEST_SUITE("host/io/raw") {
    TEST_CASE("a compressed raw file is read as it is described, if its size fits exactly") {
        const TemporaryFolder folder;
        const std::vector<std::int16_t> values = ramp<std::int16_t>(24);
        ImportRequest request = request_of(
            folder.write("v.raw.gz", gzipped(folder, "header" + bytes_of(values, true))));
        request.raw = RawLayout{{4, 3, 2}, "int16", true, 6};
        request.spacing_mm = glm::dvec3(0.5, 1, 2);
        const Volume volume = import_volume(request);
        REQUIRE(volume.type == Scalar::int16);
        CHECK(std::memcmp(volume.values.data(), values.data(), 48) == 0);
        CHECK(volume.voxel_to_patient[2].z == 2);
        request.raw->offset_bytes = 4;
        CHECK(refusal(request) ==
              "4x3x2 of int16 after 4 bytes need 52 bytes when decompressed, it has more");
        request.raw->offset_bytes = 8;
        CHECK(refusal(request) ==
              "4x3x2 of int16 need 48 bytes when decompressed, v.raw.gz has 46");
        request.read = ReadBy::gps;
        CHECK(refusal(request).find("its values are compressed") != std::string::npos);
    }
}
