#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <map>

#include "host/io/dicom/dicom_series.hpp"
#include "host/io/import.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;

namespace {

/// Slices of 2x2 voxels that are told by a table.
struct Table {
    std::vector<DicomSlice> slices;
    std::map<std::string, std::uint8_t> values;
    std::map<std::string, Component> components;
    ImportRequest request;

    /// A slice at `origin_mm`, all voxels `value`. The reference holds until the next call.
    DicomSlice& add(const std::string& name, glm::dvec3 origin_mm, std::uint8_t value) {
        DicomSlice slice;
        slice.path = "folder/" + name;
        slice.series = "1.2.3";
        slice.modality = "CT";
        slice.columns = slice.rows = 2;
        slice.x_step_mm = {0.5, 0, 0};
        slice.y_step_mm = {0, 0.5, 0};
        slice.origin_mm = origin_mm;
        values[slice.path] = value;
        slices.push_back(slice);
        return slices.back();
    }

    Volume assemble() const {
        return assemble_series("folder", slices, request,
                               [&](const DicomSlice& slice, ValueSink& sink) {
                                   const std::byte value{values.at(slice.path)};
                                   const auto type = components.find(slice.path);
                                   sink.add(
                                       std::array{value, value, value, value},
                                       type == components.end() ? Component::uint8 : type->second,
                                       slice.scale);
                               })
            .volume;
    }
};

bool reports(const Volume& volume, FindingKind kind, const std::string& words) {
    return std::any_of(volume.findings.begin(), volume.findings.end(), [&](const Finding& f) {
        return f.kind == kind && f.text.find(words) != std::string::npos;
    });
}

}  // namespace

TEST_SUITE("host/io/dicom_series") {
    TEST_CASE("slices are ordered by position, whatever their names say") {
        Table table;
        table.add("c", {1, 2, 10}, 10);
        table.add("a", {1, 2, 14}, 14);
        table.add("b", {1, 2, 12}, 12);
        const Volume volume = table.assemble();
        CHECK(std::array{volume.nx, volume.ny, volume.nz} == std::array{2, 2, 3});
        CHECK(volume.values[0] == std::byte{10});
        CHECK(volume.values[4] == std::byte{12});
        CHECK(volume.values[8] == std::byte{14});
        CHECK(volume.voxel_to_patient[2] == glm::dvec4(0, 0, 2, 0));
        CHECK(volume.voxel_to_patient[3] == glm::dvec4(1, 2, 10, 1));
        CHECK(volume.slice_places.empty());
        CHECK(volume.modality == "CT");
        CHECK(volume.findings.empty());
    }

    TEST_CASE("a tilted gantry shears: the z step is the step of the origins") {
        Table table;
        table.add("a", {0, 0, 0}, 1);
        table.add("b", {0, 1, 3}, 2);
        table.add("c", {0, 2, 6}, 3);
        const glm::dvec4 step = table.assemble().voxel_to_patient[2];
        CHECK(step.y == doctest::Approx(1));
        CHECK(step.z == doctest::Approx(3));
    }

    TEST_CASE("a missing slice is reported, and every slice stays where it is in the patient") {
        Table table;
        for (const int z : {0, 2, 4, 8, 10}) {
            table.add("z" + std::to_string(100 + z), {0, 0, z}, static_cast<std::uint8_t>(z));
        }
        const Volume volume = table.assemble();
        CHECK(volume.voxel_to_patient[2].z == doctest::Approx(2));
        CHECK(volume.slice_places == std::vector<double>{0, 1, 2, 4, 5});
        CHECK(volume.gap_slabs == std::vector<int>{2});
        CHECK(reports(volume, FindingKind::missing_slices,
                      "about 1 slice is missing, 2.000 mm in all: 4.000 mm from z104 to z108; "
                      "elsewhere 2.000 mm"));
    }

    TEST_CASE("uneven slices have places, and those below one and a half steps are no gaps") {
        Table table;
        table.add("a", {0, 0, 0}, 1);
        table.add("b", {0, 0, 2}, 2);
        table.add("c", {0, 0, 4.8}, 3);
        table.add("d", {0, 0, 6.8}, 4);
        const Volume volume = table.assemble();
        REQUIRE(volume.slice_places.size() == 4);
        CHECK(volume.slice_places[2] == doctest::Approx(2.4));
        CHECK(volume.gap_slabs.empty());
        CHECK(reports(volume, FindingKind::uneven_slices, "1 of 3 steps"));
        CHECK(reports(volume, FindingKind::uneven_slices, "2.800 mm from b to c"));
    }

    TEST_CASE("positions written with few digits are even, and their mean step counts") {
        Table table;
        for (const double z : {0.0, 0.333, 0.667, 1.0}) {
            table.add("z" + std::to_string(z), {0, 0, z}, 1);
        }
        const Volume volume = table.assemble();
        CHECK(volume.slice_places.empty());
        CHECK(volume.voxel_to_patient[2].z == doctest::Approx(1.0 / 3));
        CHECK(volume.findings.empty());
    }

    TEST_CASE("of slices at one place the first image of the series is taken, and that is said") {
        Table table;
        table.add("a", {0, 0, 0}, 1);
        table.add("copy of b", {0, 0, 2}, 9).instance_number = 7;
        table.add("b", {0, 0, 2}, 2).instance_number = 2;
        const Volume volume = table.assemble();
        CHECK(volume.nz == 2);
        CHECK(volume.values[4] == std::byte{2});
        CHECK(reports(volume, FindingKind::duplicate_slices, "copy of b has that of b"));
        CHECK(!reports(volume, FindingKind::duplicate_slices, "series of times"));
    }

    TEST_CASE("a series of times is one volume and a finding that says how many there are") {
        Table table;
        for (int time = 0; time < 3; ++time) {
            for (int z = 0; z < 2; ++z) {
                table
                    .add("t" + std::to_string(time) + "z" + std::to_string(z), {0, 0, z},
                         static_cast<std::uint8_t>(10 * time + z))
                    .instance_number = 2 * time + z;
            }
        }
        const Volume volume = table.assemble();
        CHECK(volume.nz == 2);
        CHECK(volume.maximum == 1);
        CHECK(reports(volume, FindingKind::duplicate_slices, "each position occurs 3 times"));
    }

    TEST_CASE("several series are listed, and one is chosen by number or UID") {
        Table table;
        table.add("scout", {0, 0, 1}, 9).series = "4.5.6";
        table.slices.back().series_number = 1;
        table.slices.back().description = "Topogram";
        for (const int z : {0, 2}) {
            table.add("z" + std::to_string(z), {0, 0, z}, 1).series_number = 2;
        }
        CHECK_THROWS_WITH_AS(table.assemble(),
                             "folder: holds 2 series: choose one by series=N or its UID:\n"
                             "  1: 4.5.6 'Topogram', CT, 2x2x1, SeriesNumber 1\n"
                             "  2: 1.2.3 '', CT, 2x2x2, SeriesNumber 2",
                             ImportError);
        for (const char* wish : {"2", "1.2.3"}) {
            table.request.series = wish;
            const Volume volume = table.assemble();
            CHECK(volume.nz == 2);
            CHECK(reports(volume, FindingKind::other_series, "1: 4.5.6 'Topogram'"));
        }
        table.request.series = "3";
        CHECK_THROWS_WITH_AS(table.assemble(), doctest::Contains("has no series '3', it holds 2"),
                             ImportError);
    }

    TEST_CASE("without UIDs, what slices share tells series apart") {
        Table table;
        table.add("a", {0, 0, 0}, 1).series = "";
        table.add("b", {0, 0, 2}, 1).series = "";
        CHECK(table.assemble().nz == 2);
        table.add("m", {0, 0, 4}, 1).series = "";
        table.slices.back().modality = "MR";
        CHECK_THROWS_WITH_AS(table.assemble(), doctest::Contains("2: (no UID) '', MR, 2x2x1"),
                             ImportError);
    }

    TEST_CASE("of one series in two orientations the larger set is read, the other reported") {
        Table table;
        for (const int z : {0, 2, 4}) {
            table.add("z" + std::to_string(z), {0, 0, z}, 1);
        }
        table.add("sagittal", {5, 0, 0}, 2).x_step_mm = {0, 0, 0.5};
        const Volume volume = table.assemble();
        CHECK(volume.nz == 3);
        CHECK(volume.maximum == 1);
        CHECK(reports(volume, FindingKind::mixed_orientations,
                      "1 slices of 2x2 in another orientation or size are left out, the first is "
                      "sagittal"));
    }

    TEST_CASE("thickness is not distance, and that they differ is said") {
        Table table;
        for (const int z : {0, 2, 4}) {
            table.add("z" + std::to_string(z), {0, 0, z}, 1).thickness_mm = 3;
        }
        const Volume volume = table.assemble();
        CHECK(volume.voxel_to_patient[2].z == 2);
        CHECK(reports(volume, FindingKind::thickness_differs, "2.000 mm apart and 3.000 mm thick"));
    }

    TEST_CASE("slices that do not lie in a straight row are reported") {
        Table table;
        table.add("a", {0, 0, 0}, 1);
        table.add("b", {0.4, 0, 2}, 1);
        table.add("c", {0, 0, 4}, 1);
        CHECK(reports(table.assemble(), FindingKind::uneven_slices,
                      "shifted sideways by up to 0.400 mm"));
    }

    TEST_CASE("each slice has its own slope and intercept, in double") {
        Table table;
        table.add("a", {0, 0, 0}, 200).scale = {0.5, -10};
        table.add("b", {0, 0, 2}, 200).scale = {1.25, 0.125};
        const Volume volume = table.assemble();
        REQUIRE(volume.type == Scalar::float32);
        std::array<float, 8> values{};
        std::memcpy(values.data(), volume.values.data(), sizeof values);
        CHECK(values[0] == 90);
        CHECK(values[7] == 250.125F);
        CHECK(reports(volume, FindingKind::note, "each slice has its own rescale slope, 0.5 to"));
    }

    TEST_CASE("slices of different types meet in one that holds both") {
        Table table;
        table.add("a", {0, 0, 0}, 200);
        table.add("b", {0, 0, 2}, 255);
        table.components["folder/b"] = Component::int8;
        const Volume volume = table.assemble();
        REQUIRE(volume.type == Scalar::int16);
        std::array<std::int16_t, 8> values{};
        std::memcpy(values.data(), volume.values.data(), sizeof values);
        CHECK(values[0] == 200);
        CHECK(values[7] == -1);
    }

    TEST_CASE("files without positions have no order and are refused") {
        Table table;
        table.add("a", {0, 0, 0}, 1);
        table.add("b", {0, 0, 2}, 2).position_stated = false;
        CHECK_THROWS_WITH_AS(table.assemble(), doctest::Contains("b states no position"),
                             ImportError);
    }

    TEST_CASE("frames without positions need a distance: the file's, or one that is given") {
        Table table;
        for (int frame = 0; frame < 3; ++frame) {
            DicomSlice& slice = table.add("f", {0, 0, 5}, 1);
            slice.frame = frame;
            slice.frames = 3;
            slice.position_stated = false;
        }
        CHECK_THROWS_WITH_AS(table.assemble(), doctest::Contains("give spacing=x,y,z"),
                             ImportError);
        table.request.spacing_mm = glm::dvec3(1, 1, 7);
        CHECK(table.assemble().voxel_to_patient[2].z == 7);
        for (DicomSlice& slice : table.slices) {
            slice.frame_step_mm = 1.5;
        }
        const Volume volume = table.assemble();
        CHECK(volume.voxel_to_patient[2].z == 1.5);
        CHECK(volume.voxel_to_patient[3].z == 5);
        CHECK(reports(volume, FindingKind::assumption, "taken as 1.5 mm apart (0018,0088)"));
    }

    TEST_CASE("a single slice is a volume whose z step is an assumption that is reported") {
        Table table;
        table.add("a", {0, 0, 0}, 1).thickness_mm = 2.5;
        const Volume volume = table.assemble();
        CHECK(volume.nz == 1);
        CHECK(volume.voxel_to_patient[2].z == 2.5);
        CHECK(reports(volume, FindingKind::assumption, "2.5 mm is taken along z (its thickness)"));
    }

    TEST_CASE("no slice is missing between slices that touch") {
        Table table;
        for (int i = 0; i < 8; ++i) {  // Overlapping slices below, touching ones above.
            const double z = i < 5 ? 3.0 * i : 12 + 6.0 * (i - 4);
            table.add("z" + std::to_string(i), {0, 0, z}, 1).thickness_mm = 6;
        }
        const Volume volume = table.assemble();
        CHECK_FALSE(reports(volume, FindingKind::missing_slices, ""));
        CHECK(volume.gap_slabs.empty());
        CHECK(reports(volume, FindingKind::uneven_slices, "6.000 mm from"));
    }

    TEST_CASE("blocks of thicker slices are no gaps, but a slice missing in a block is") {
        Table table;
        double z = 0;
        for (int i = 0; i < 10; ++i) {
            table.add("thin" + std::to_string(i), {0, 0, z}, 1).thickness_mm = 2;
            z += i < 9 ? 2 : 5;  // From the middle of a slice of 2 mm to that of one of 8 mm.
        }
        for (int i = 0; i < 5; ++i, z += 8) {
            table.add("thick" + std::to_string(i), {0, 0, z}, 1).thickness_mm = 8;
        }
        const Volume volume = table.assemble();
        CHECK(volume.gap_slabs.empty());
        CHECK_FALSE(reports(volume, FindingKind::missing_slices, ""));
        CHECK_FALSE(reports(volume, FindingKind::thickness_differs, ""));
        CHECK(reports(volume, FindingKind::uneven_slices, "5 of 14 steps"));
        CHECK(reports(volume, FindingKind::uneven_slices, "as their thicknesses, 2 to 8 mm"));
        CHECK(volume.slice_places.back() == doctest::Approx((18 + 5 + 32) / 2.0));
        table.slices.erase(table.slices.begin() + 12);
        const Volume gap = table.assemble();
        CHECK(gap.gap_slabs == std::vector<int>{11});
        CHECK(reports(gap, FindingKind::missing_slices,
                      "about 1 slice is missing, 8.000 mm in all: 16.000 mm from thick1 to"));
    }

    TEST_CASE("slices that are 0.06 mm beside the row are told, 0.04 mm are not") {
        for (const double sideways : {0.04, 0.06}) {
            Table table;
            table.add("a", {0, 0, 0}, 1).x_step_mm = {2, 0, 0};
            table.add("b", {sideways, 0, 2}, 1).x_step_mm = {2, 0, 0};
            table.add("c", {0, 0, 4}, 1).x_step_mm = {2, 0, 0};
            for (DicomSlice& slice : table.slices) {
                slice.y_step_mm = {0, 2, 0};
            }
            CHECK(reports(table.assemble(), FindingKind::uneven_slices, "shifted sideways") ==
                  (sideways > 0.05));
        }
    }

    TEST_CASE("a series is chosen by its SeriesNumber, too, but its rank comes first") {
        Table table;
        for (const int number : {3, 2, 701}) {
            table
                .add("n" + std::to_string(number), {0, 0, 1},
                     static_cast<std::uint8_t>(number % 200))
                .series_number = number;
            table.slices.back().series = "1.2." + std::to_string(number);
        }
        const auto value = [&](const char* wish) {
            table.request.series = wish;
            return table.assemble().minimum;
        };
        CHECK(value("701") == 101);
        CHECK(value("1.2.3") == 3);
        CHECK(value("2") == 3);
        CHECK(reports(table.assemble(), FindingKind::other_series,
                      "series=2 is number 2 of the list; the series with SeriesNumber 2 is left "
                      "out, its UID is 1.2.2"));
        table.request.series = "";
        CHECK_THROWS_WITH_AS(table.assemble(),
                             doctest::Contains("3: 1.2.701 '', CT, 2x2x1, SeriesNumber 701"),
                             ImportError);
    }
}
