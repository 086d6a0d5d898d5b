#include <doctest/doctest.h>

#include <algorithm>
#include <map>

#include "host/io/dicom_series.hpp"
#include "host/io/import.hpp"
#include "tests/host/io/volume_files.hpp"

using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

/// A folder whose files are empty; what they hold is told by a table.
struct Series {
    TemporaryFolder folder;
    std::map<std::string, DicomSlice> slices;
    std::map<std::string, std::uint8_t> values;
    std::map<std::string, Component> components;

    /// A 2x2 slice at `origin_mm`, all voxels `value`.
    DicomSlice& add(const std::string& name, glm::dvec3 origin_mm, std::uint8_t value) {
        DicomSlice slice;
        slice.path = folder.write(name, "");
        slice.series = "1.2.3";
        slice.columns = slice.rows = 2;
        slice.x_step_mm = {0.5, 0, 0};
        slice.y_step_mm = {0, 0.5, 0};
        slice.origin_mm = origin_mm;
        values[name] = value;
        return slices[name] = slice;
    }

    Decoded assemble() const {
        return assemble_series(
            std::filesystem::path(folder.file("")),
            [&](const std::filesystem::path& path) -> std::optional<DicomSlice> {
                const auto found = slices.find(path.filename().string());
                return found == slices.end() ? std::nullopt : std::optional(found->second);
            },
            [&](const std::filesystem::path& path) {
                Decoded decoded;
                decoded.dims = {2, 2, 1};
                decoded.values.assign(4, std::byte{values.at(path.filename().string())});
                if (components.contains(path.filename().string())) {
                    decoded.component = components.at(path.filename().string());
                }
                return decoded;
            });
    }
};

bool notes_say(const Decoded& volume, const std::string& words) {
    return std::any_of(volume.notes.begin(), volume.notes.end(), [&](const std::string& note) {
        return note.find(words) != std::string::npos;
    });
}

}  // namespace

TEST_SUITE("host/io/dicom_series") {
    TEST_CASE("slices are ordered by position, whatever their names say") {
        Series series;
        series.add("c", {1, 2, 10}, 10);
        series.add("a", {1, 2, 14}, 14);
        series.add("b", {1, 2, 12}, 12);
        const Decoded volume = series.assemble();
        CHECK(volume.dims == std::array{2, 2, 3});
        CHECK(volume.values[0] == std::byte{10});
        CHECK(volume.values[4] == std::byte{12});
        CHECK(volume.values[8] == std::byte{14});
        CHECK(volume.voxel_to_patient[2] == glm::dvec4(0, 0, 2, 0));
        CHECK(volume.voxel_to_patient[3] == glm::dvec4(1, 2, 10, 1));
        CHECK(volume.notes.empty());
    }

    TEST_CASE("a tilted gantry shears: the z step is the step of the origins") {
        Series series;
        series.add("a", {0, 0, 0}, 1);
        series.add("b", {0, 1, 3}, 2);
        series.add("c", {0, 2, 6}, 3);
        const glm::dvec4 step = series.assemble().voxel_to_patient[2];
        CHECK(step.y == doctest::Approx(1));
        CHECK(step.z == doctest::Approx(3));
    }

    TEST_CASE("a missing slice is noted and does not stretch the others") {
        Series series;
        for (const int z : {0, 2, 4, 8, 10}) {
            series.add("z" + std::to_string(100 + z), {0, 0, z}, static_cast<std::uint8_t>(z));
        }
        const Decoded volume = series.assemble();
        CHECK(volume.voxel_to_patient[2].z == doctest::Approx(2));
        CHECK(notes_say(volume, "uneven slices: 4.000 mm from z104 to z108, elsewhere 2.000 mm"));
    }

    TEST_CASE("a slice that is there twice is taken once, and noted") {
        Series series;
        series.add("a", {0, 0, 0}, 1);
        series.add("b", {0, 0, 2}, 2);
        series.add("copy of b", {0, 0, 2}, 2);
        const Decoded volume = series.assemble();
        CHECK(volume.dims[2] == 2);
        CHECK(notes_say(volume, "copy of b has the position of b and is left out"));
    }

    TEST_CASE("of two series the larger is taken, and the other is noted") {
        Series series;
        series.add("a", {0, 0, 0}, 1);
        series.add("b", {0, 0, 2}, 2);
        series.add("scout", {0, 0, 1}, 9).series = "4.5.6";
        series.folder.write("notes.txt", "");
        const Decoded volume = series.assemble();
        CHECK(volume.dims[2] == 2);
        CHECK(notes_say(volume, "1 slices of 2x2 of another series"));
        CHECK(notes_say(volume, "the first is scout"));
        CHECK(notes_say(volume, "1 files are not DICOM images"));
    }

    TEST_CASE("slices of different types meet in float64") {
        Series series;
        series.add("a", {0, 0, 0}, 200);
        series.add("b", {0, 0, 2}, 255);
        series.components["b"] = Component::int8;
        const Decoded volume = series.assemble();
        CHECK(volume.component == Component::float64);
        CHECK(volume.values.size() == 8 * sizeof(double));
        std::array<double, 8> values{};
        std::memcpy(values.data(), volume.values.data(), volume.values.size());
        CHECK(values[0] == 200);
        CHECK(values[7] == -1);
    }

    TEST_CASE("slices without positions have no order and are refused") {
        Series series;
        series.add("a", {0, 0, 0}, 1);
        series.add("b", {0, 0, 2}, 2).position_stated = false;
        CHECK_THROWS_WITH_AS(series.assemble(), doctest::Contains("b states no position"),
                             ImportError);
    }

    TEST_CASE("one slice is no volume") {
        Series series;
        series.add("a", {0, 0, 0}, 1);
        CHECK_THROWS_WITH_AS(series.assemble(), doctest::Contains("has 1 slices, must be 2 to"),
                             ImportError);
    }
}
