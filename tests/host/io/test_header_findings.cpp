// Findings about headers that leave out, or contradict, a fact.
#include <doctest/doctest.h>

#include <algorithm>

#include "host/io/import.hpp"
#include "tests/host/io/volume_writers.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

bool reports(const Volume& volume, FindingKind kind, const std::string& words) {
    return std::any_of(volume.findings.begin(), volume.findings.end(), [&](const Finding& f) {
        return f.kind == kind && f.text.find(words) != std::string::npos;
    });
}

Grid cube() {
    Grid grid{{4, 3, 2}, glm::dmat4(1.0), ramp<std::int16_t>(24)};
    return grid;
}

std::string meta_image(const std::string& orientation) {
    return "NDims = 3\nDimSize = 4 3 2\nElementType = MET_UCHAR\nElementSpacing = 1 1 1\n" +
           orientation + "ElementDataFile = LOCAL\n" + std::string(24, 'x');
}

/// Slices in a folder, of which each lies `sideways_mm` beside the one before.
Volume series(const std::string& modality, double sideways_mm) {
    const TemporaryFolder folder;
    Grid grid = cube();
    grid.dims = {4, 3, 3};
    grid.values = ramp<std::int16_t>(36);
    grid.affine[2] = {0, sideways_mm, 1, 0};
    for (int z = 0; z < 3; ++z) {
        folder.write("s" + std::to_string(z),
                     dicom_slice(grid, z).text(8, 0x60, "CS", modality).file());
    }
    return import_volume(folder.file(""));
}

}  // namespace

TEST_SUITE("host/io/header_findings") {
    TEST_CASE("an AnatomicalOrientation of question marks is not stated") {
        const TemporaryFolder folder;
        for (const char* unknown : {"", "AnatomicalOrientation = ???\n"}) {
            CAPTURE(unknown);
            CHECK(reports(import_volume(folder.write("v.mha", meta_image(unknown))),
                          FindingKind::assumption, "states no AnatomicalOrientation"));
        }
        CHECK_FALSE(reports(
            import_volume(folder.write("v.mha", meta_image("AnatomicalOrientation = RAI\n"))),
            FindingKind::assumption, ""));
    }

    TEST_CASE("a tilt is one of CT and from 0.1 degrees on, and other shears are told as shears") {
        CHECK(reports(series("CT", 0.1), FindingKind::gantry_tilt, "meet at 84.29 degrees"));
        CHECK_FALSE(reports(series("CT", 0.0016), FindingKind::gantry_tilt, ""));
        CHECK_FALSE(reports(series("CT", 0.0016), FindingKind::note, "sheared"));
        CHECK(reports(series("CT", 0.0019), FindingKind::gantry_tilt, "meet at 89.89 degrees"));
        const Volume mr = series("MR", 0.1);
        CHECK_FALSE(reports(mr, FindingKind::gantry_tilt, ""));
        CHECK(reports(mr, FindingKind::note, "sheared: the y and z axes meet at 84.29 degrees"));
        CHECK_FALSE(reports(mr, FindingKind::note, "gantry"));
    }

    TEST_CASE("a unit of length that is missing is a note and no assumed place") {
        const TemporaryFolder folder;
        NiftiHeader header = nifti1_header(cube());
        header.put<char>(123, 0);
        const Volume volume =
            import_volume(folder.write("v.nii", header.bytes() + bytes_of(cube().values)));
        CHECK(reports(volume, FindingKind::note, "states no unit of length: read as millimeters"));
        CHECK_FALSE(is_assumed(volume));
        std::string nrrd = nrrd_file(cube());
        nrrd.insert(nrrd.find("space directions"), "space units: \"\" \"\" \"\"\n");
        CHECK_FALSE(is_assumed(import_volume(folder.write("v.nrrd", nrrd))));
        nrrd.replace(nrrd.find("\"\" \"\""), 5, "\"inch\" \"inch\"");
        CHECK(is_assumed(import_volume(folder.write("v.nrrd", nrrd))));
    }
}
