// DICOM slices that are there twice: the same image of an archive in two files.
#include <doctest/doctest.h>

#include <algorithm>

#include "host/io/import.hpp"
#include "tests/host/io/dicom_files.hpp"
#include "tests/host/io/formats/read_frame.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

/// A slice of 2x2 voxels with a UID of its own.
DicomSet slice(int frame, int place) {
    DicomSet set = dicom_image(2, 2, bytes_of(std::vector<std::int16_t>(4, 7)));
    dicom_place(set, {0, 0, 5.0 * place}, {1, 0, 0}, {0, 1, 0}, 1, 1);
    set.text(0x20, 0x13, "IS", std::to_string(10 * frame + place));
    set.text(8, 0x18, "UI", "1.2.3." + std::to_string(10 * frame + place));
    set.text(0x18, 0x1060, "DS", std::to_string(40 * frame));
    return set;
}

void write_series(const TemporaryFolder& folder) {
    for (const int frame : {1, 2, 3}) {
        for (const int place : {0, 1}) {
            folder.write("IM" + std::to_string(10 * frame + place), slice(frame, place).file());
        }
    }
}

/// Texts of the findings about copies.
std::vector<std::string> copies(const Volume& volume) {
    std::vector<std::string> texts;
    for (const Finding& finding : volume.findings) {
        if (finding.text.find("left out") != std::string::npos) {
            texts.push_back(finding.text);
        }
    }
    return texts;
}

}  // namespace

TEST_SUITE("host/io/copies of DICOM slices") {
    TEST_CASE("a time series with a copy of a file is a time series") {
        const TemporaryFolder folder;
        write_series(folder);
        CHECK(copies(read_frame(folder.file(""), 2)).empty());
        folder.write("IM31 (1)", slice(3, 1).file());
        const Volume volume = read_frame(folder.file(""), 2);
        CHECK(volume.frames == 3);
        CHECK(copies(volume) ==
              std::vector<std::string>{"1 copy of a slice is left out: IM31 (1) has the image of "
                                       "IM31 (SOP Instance UID 1.2.3.31)"});
        folder.write("IM31 (2)", slice(3, 1).file());
        CHECK(copies(read_frame(folder.file(""), 2)) ==
              std::vector<std::string>{"2 copies of slices are left out: IM31 (1) has the image of "
                                       "IM31 (SOP Instance UID 1.2.3.31), for example"});
    }

    TEST_CASE("slices that differ are no copies, though all have one UID") {
        const TemporaryFolder folder;
        for (const int frame : {1, 2}) {
            for (const int place : {0, 1}) {
                DicomSet set = slice(frame, place);
                set.text(8, 0x18, "UI", "1.2.3.4").text(0x20, 0x13, "IS", "1");
                folder.write("IM" + std::to_string(10 * frame + place), set.file());
            }
        }
        const Volume volume = read_frame(folder.file(""), 2);
        CHECK(volume.frames == 2);
        CHECK(volume.nz == 2);
        CHECK(copies(volume).empty());
        DicomSet turned = slice(1, 0);
        dicom_place(turned, {0, 0, 0}, {0, 1, 0}, {0, 0, 1}, 1, 1);
        turned.text(8, 0x18, "UI", "1.2.3.4").text(0x20, 0x13, "IS", "1");
        folder.write("IM40", turned.file());
        const std::vector<std::string> texts = copies(read_frame(folder.file(""), 0));
        REQUIRE(texts.size() == 1);
        CHECK(texts[0].find("copy of a slice") == std::string::npos);
    }
}
