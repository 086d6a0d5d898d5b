// Raw files that are compressed by gzip.
#include <doctest/doctest.h>

#include <algorithm>

#include "host/io/import.hpp"
#include "tests/host/io/volume_writers.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

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
        request.raw->offset_bytes = 6;
        const std::string packed = gzipped(folder, "header" + bytes_of(values, true));
        folder.write("v.raw.gz", packed.substr(0, packed.size() - 8));  // Without its checksum.
        CHECK(refusal(request).find("are damaged: the checksum") != std::string::npos);
        request.read = ReadBy::gps;
        CHECK(refusal(request).find("its values are compressed") != std::string::npos);
    }
}
