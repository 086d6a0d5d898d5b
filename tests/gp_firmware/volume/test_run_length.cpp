#include <doctest/doctest.h>

#include "gp_firmware/volume/run_length.hpp"
#include "tests/gp_firmware/test_volume.hpp"

using namespace pxpl5;
using namespace pxpl5::gp;
using pxpl5::test::make_volume;
using pxpl5::test::Volume;

namespace {

/// A single row twice, as a slice; ny must be 2.
RowIndex index_of_row(const std::vector<double>& row, Scalar type) {
    const Volume volume =
        make_volume({static_cast<int>(row.size()), 2, 2}, type,
                    [&](int x, int, int) { return row[static_cast<std::size_t>(x)]; });
    return index_rows(volume.shape, volume.slice(0));
}

}  // namespace

TEST_SUITE("gp/run_length") {
    TEST_CASE("a row becomes its runs, in order, if they are eight voxels long on average") {
        std::vector<double> row(16, 5);
        row[15] = -3;
        const RowIndex index = index_of_row(row, Scalar::int16);
        REQUIRE(index.runs_of(1).size() == 2);
        CHECK(index.runs_of(1)[0].value == 5);
        CHECK(index.runs_of(1)[0].end == 15);
        CHECK(index.runs_of(1)[1].value == -3);
        CHECK(index.runs_of(1)[1].end == 16);
        row[3] = 4;
        CHECK(index_of_row(row, Scalar::int16).runs.empty());
    }

    TEST_CASE("ranges are the least and greatest value of each row and of the slice") {
        const Volume volume = make_volume(
            {3, 2, 2}, Scalar::int16, [](int x, int y, int) { return y == 0 ? x - 7 : 40 + x; });
        const RowIndex index = index_rows(volume.shape, volume.slice(0));
        CHECK(index.ranges[0].minimum == -7);
        CHECK(index.ranges[0].maximum == -5);
        CHECK(index.ranges[1].minimum == 40);
        CHECK(index.ranges[1].maximum == 42);
        CHECK(index.slice.minimum == -7);
        CHECK(index.slice.maximum == 42);
    }

    TEST_CASE("a voxel that is not a number counts as minus infinity") {
        const double nan = std::numeric_limits<double>::quiet_NaN();
        const RowIndex index = index_of_row({1, nan, 2}, Scalar::float32);
        CHECK(index.ranges[0].minimum == -std::numeric_limits<float>::infinity());
        CHECK(index.ranges[0].maximum == 2);
        const RowIndex none = index_of_row({nan, nan}, Scalar::float32);
        CHECK(none.ranges[0].maximum == -std::numeric_limits<float>::infinity());
    }

    TEST_CASE("an index stays within the size that is planned for it") {
        std::vector<double> row(64);
        for (std::size_t x = 0; x < row.size(); ++x) row[x] = double(x / 8);
        const RowIndex index = index_of_row(row, Scalar::uint8);
        CHECK(index.runs_of(0).size() == 8);
        const VolumeShape shape{64, 2, 2, Scalar::uint8, glm::dmat4(1.0), 0, 7};
        CHECK(index.size_bytes() == max_index_bytes(shape));
    }
}
