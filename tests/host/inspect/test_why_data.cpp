// `why` on a real scan: bone of a pelvis.
#include <doctest/doctest.h>
#include <zlib.h>

#include <filesystem>
#include <fstream>

#include "tests/host/inspect/ray_check.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

const std::filesystem::path file =
    std::filesystem::path(PXPL5_SOURCE_DIR) / ".." / "shared/data/ct/pelvis_128x128x56.nrrd";

/// The file's voxels lie behind an empty line, in gzip; its header is known.
host::Volume pelvis() {
    host::Volume volume;
    volume.name = "pelvis";
    volume.nx = volume.ny = 128;
    volume.nz = 56;
    volume.type = Scalar::int16;
    volume.voxel_to_patient[0][0] = 2.85938;
    volume.voxel_to_patient[1][1] = 2.36719;
    volume.voxel_to_patient[2][2] = 3;
    volume.values.resize(128 * 128 * 56 * 2);
    std::ifstream stream(file, std::ios::binary);
    std::string text((std::istreambuf_iterator<char>(stream)), {});
    text.erase(0, text.find("\n\n") + 2);
    z_stream inflater{};
    REQUIRE(inflateInit2(&inflater, 15 + 32) == Z_OK);
    inflater.next_in = reinterpret_cast<Bytef*>(text.data());
    inflater.avail_in = static_cast<uInt>(text.size());
    inflater.next_out = reinterpret_cast<Bytef*>(volume.values.data());
    inflater.avail_out = static_cast<uInt>(volume.values.size());
    inflate(&inflater, Z_FINISH);
    REQUIRE(inflater.avail_out == 0);
    inflateEnd(&inflater);
    volume.minimum = -32768;
    volume.maximum = 32767;
    return volume;
}

}  // namespace

TEST_SUITE("why") {
    TEST_CASE("a pixel of bone names the cell whose values straddle 300") {
        if (!std::filesystem::exists(file)) {
            MESSAGE("SKIPPED: no file ", file.string());
            return;
        }
        RecordedSurface recorded(pelvis(), 4, 2);
        recorded.add_surface(300);
        recorded.draw({{20, 10}, 1.0}, 512, 512);
        check_pixels(recorded, 300, 200);
    }
}
