// Windows of gray values, units and standardized uptake values of DICOM files.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "host/io/import.hpp"
#include "tests/host/io/dicom_files.hpp"

using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

constexpr int side = 2;

/// A slice at z, of a series of its kind.
DicomSet slice_at(double z, const char* modality) {
    DicomSet set = dicom_image(side, side, std::string(std::size_t{side} * side * 2, '\1'));
    set.text(8, 0x60, "CS", modality);
    return dicom_place(set, {0, 0, z}, {1, 0, 0}, {0, 1, 0}, 1, 1);
}

/// Dose and times of an injection an hour before the scan, for a half-life of an hour.
DicomSet tracer() {
    DicomSet set;
    return set.text(0x18, 0x1072, "TM", "090000.50")
        .text(0x18, 0x1074, "DS", "200000000")
        .text(0x18, 0x1075, "DS", "3600");
}

/// A slice of PET: 50 kg, 200 MBq, of which half is left at the scan.
DicomSet pet_at(double z) {
    DicomSet set = slice_at(z, "PT");
    set.text(0x54, 0x1001, "CS", "BQML").text(0x54, 0x1102, "CS", "START");
    set.text(0x28, 0x51, "CS", "DECY\\ATTN\\SCAT").text(0x10, 0x1030, "DS", "50");
    set.text(8, 0x21, "DA", "20240229").text(8, 0x31, "TM", "100000.5");
    set.text(8, 0x22, "DA", "20240229").text(8, 0x32, "TM", "100500");
    return set.sequence(0x54, 0x16, {tracer()});
}

Volume volume_of(const DicomSet& set) {
    const TemporaryFolder folder;
    return import_volume(folder.write("x.dcm", set.file()));
}

/// The reason why a PET file has no uptake values.
std::string reason_of(const DicomSet& set) {
    const Volume volume = volume_of(set);
    CHECK(volume.suv_per_value == 0);
    const std::string begin = "no standardized uptake values (SUV): ";
    for (const Finding& finding : volume.findings) {
        if (finding.text.starts_with(begin)) {
            return finding.text.substr(begin.size());
        }
    }
    return "";
}

constexpr double expected_suv = 50'000 / 100e6;  // Grams for each becquerel that is left.

}  // namespace

TEST_SUITE("host/io/dicom_display") {
    TEST_CASE("windows keep their order and their names, and equal ones appear once") {
        DicomSet set = slice_at(0, "CT");
        set.text(0x28, 0x1050, "DS", "-600\\40\\-600\\300")
            .text(0x28, 0x1051, "DS", "1500\\400\\1500\\2e3");
        set.text(0x28, 0x1055, "LO", "LUNG\\SOFT TISSUE\\AGAIN");
        CHECK(volume_of(set).windows == std::vector<NamedWindow>{{"LUNG", 1500, -600},
                                                                 {"SOFT TISSUE", 400, 40},
                                                                 {"", 2000, 300}});
    }

    TEST_CASE("names of windows keep their letters") {
        DicomSet set = slice_at(0, "CT");
        set.text(8, 5, "CS", "ISO_IR 100").text(0x28, 0x1050, "DS", "40");
        set.text(0x28, 0x1051, "DS", "400")
            .text(0x28, 0x1055, "LO",
                  "Sch\xe4"
                  "del");
        REQUIRE(volume_of(set).windows.size() == 1);
        CHECK(volume_of(set).windows[0].name ==
              "Sch\xc3\xa4"
              "del");
    }

    TEST_CASE("a window that is none is left out, and the file is read") {
        DicomSet set = slice_at(0, "CT");
        set.text(0x28, 0x1050, "DS", "40\\1e300\\50").text(0x28, 0x1051, "DS", "0\\400\\nan");
        CHECK(volume_of(set).windows.empty());
        set.text(0x28, 0x1050, "DS", "forty").text(0x28, 0x1051, "DS", "400");
        CHECK(volume_of(set).windows.empty());
        set.text(0x28, 0x1050, "DS", "40\\50").text(0x28, 0x1051, "DS", "400");
        CHECK(volume_of(set).windows == std::vector<NamedWindow>{{"", 400, 40}});
    }

    TEST_CASE("a frame's own window counts before that of the file") {
        DicomSet set = dicom_image(side, side, std::string(std::size_t{side} * side * 4, '\1'));
        set.text(0x28, 8, "IS", "2").text(0x28, 0x1050, "DS", "1").text(0x28, 0x1051, "DS", "1");
        dicom_place(set, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 1, 1);
        std::vector<DicomSet> frames;
        for (const double z : {0.0, 1.0}) {
            DicomSet position, window, frame;
            position.text(0x20, 0x32, "DS", dicom_numbers({0, 0, z}));
            window.text(0x28, 0x1050, "DS", "70").text(0x28, 0x1051, "DS", "80");
            window.text(0x28, 0x1055, "LO", "frame");
            frame.sequence(0x20, 0x9113, {position}).sequence(0x28, 0x9132, {window});
            frames.push_back(frame);
        }
        set.sequence(0x5200, 0x9230, frames);
        CHECK(volume_of(set).windows == std::vector<NamedWindow>{{"frame", 80, 70}});
    }

    TEST_CASE("uptake values follow from weight, dose and the decay until the scan") {
        const Volume volume = volume_of(pet_at(0));
        CHECK(volume.unit == "Bq/ml");
        CHECK(volume.suv_per_value == doctest::Approx(expected_suv).epsilon(1e-12));
    }

    TEST_CASE("an injection has its own date, or was before midnight") {
        DicomSet given = tracer(), set = pet_at(0);
        given.text(0x18, 0x1078, "DT", "20240229060000.5");  // Four half-lives before.
        CHECK(volume_of(set.sequence(0x54, 0x16, {given})).suv_per_value ==
              doctest::Approx(50'000 / 12.5e6).epsilon(1e-12));
        set = pet_at(0);
        set.text(8, 0x31, "TM", "0030").text(8, 0x32, "TM", "0030");
        given = tracer();
        given.text(0x18, 0x1072, "TM", "2330");
        CHECK(volume_of(set.sequence(0x54, 0x16, {given})).suv_per_value ==
              doctest::Approx(expected_suv).epsilon(1e-12));
    }

    TEST_CASE("a clock that differs, or a dose in MBq, gives no uptake values") {
        DicomSet given = tracer();
        given.text(0x18, 0x1072, "TM", "100500");  // Five minutes after the scan: a day before.
        CHECK(reason_of(pet_at(0).sequence(0x54, 0x16, {given})).starts_with("23.92 half-lives"));
        given = tracer();
        given.text(0x18, 0x1074, "DS", "200");
        CHECK(reason_of(pet_at(0).sequence(0x54, 0x16, {given}))
                  .starts_with("the dose (0018,1074)"
                               " is 200 Bq"));
        given.text(0x18, 0x1074, "DS", "1e-300");
        DicomSet admin = pet_at(0);
        admin.text(0x54, 0x1102, "CS", "ADMIN").text(0x10, 0x1030, "DS", "70");
        CHECK(reason_of(admin.sequence(0x54, 0x16, {given})).starts_with("the dose"));
        CHECK(reason_of(pet_at(0).text(0x10, 0x1030, "DS", "70000")).find("70000 kg") !=
              std::string::npos);
    }

    TEST_CASE("an offset from UTC counts against that of the scan") {
        DicomSet given = tracer(), set = pet_at(0);
        given.text(0x18, 0x1078, "DT", "20240229080000.5+0000");
        // Two hours before by the clocks, one hour before in truth.
        set.text(8, 0x201, "SH", "+0100");
        CHECK(volume_of(set.sequence(0x54, 0x16, {given})).suv_per_value ==
              doctest::Approx(expected_suv).epsilon(1e-12));
        set.text(8, 0x201, "SH", "-0530");  // 02:30 by the scan's clock.
        CHECK(volume_of(set).suv_per_value ==
              doctest::Approx(50'000 / 200e6 * std::exp2(7.5)).epsilon(1e-12));
        CHECK(reason_of(set.text(8, 0x201, "SH", "+0400")).starts_with("the injection has no"));
        // Without the scan's offset, the clock must be that of 1072, which says 09:00.
        CHECK(reason_of(pet_at(0).sequence(0x54, 0x16, {given})).starts_with("the injection"));
        given.text(0x18, 0x1078, "DT", "20240229090000.5+0000");
        CHECK(volume_of(pet_at(0).sequence(0x54, 0x16, {given})).suv_per_value ==
              doctest::Approx(expected_suv).epsilon(1e-12));
    }

    TEST_CASE("values that are corrected to the injection need no times") {
        DicomSet set = pet_at(0);
        set.text(0x54, 0x1102, "CS", "ADMIN").remove(8, 0x21).remove(8, 0x32);
        CHECK(volume_of(set).suv_per_value == doctest::Approx(50'000 / 200e6).epsilon(1e-12));
    }

    TEST_CASE("values in g/ml are uptake values") {
        DicomSet set = pet_at(0);
        set.text(0x54, 0x1001, "CS", "GML").remove(0x10, 0x1030);
        const Volume volume = volume_of(set);
        CHECK(volume.unit == "g/ml");
        CHECK(volume.suv_per_value == 1);
        CHECK(reason_of(set.text(0x54, 0x1006, "CS", "LBM")) ==
              "SUV type (0054,1006) is LBM, must be BW");
    }

    TEST_CASE("what is missing for uptake values is named") {
        CHECK(reason_of(pet_at(0).remove(0x10, 0x1030)).starts_with("the patient's weight"));
        CHECK(reason_of(pet_at(0).text(0x10, 0x1030, "DS", "0")) ==
              "the patient's weight is '0' (0010,1030), must be above 0 kg");
        CHECK(reason_of(pet_at(0).text(8, 0x32, "TM", "")).starts_with("the acquisition has no"));
        CHECK(reason_of(pet_at(0).remove(0x54, 0x16)).starts_with("the dose"));
        CHECK(reason_of(pet_at(0).text(0x28, 0x51, "CS", "DECY")).find("must have ATTN") !=
              std::string::npos);
        CHECK(reason_of(pet_at(0).text(0x54, 0x1102, "CS", "NONE")).find("'NONE'") !=
              std::string::npos);
        CHECK(reason_of(pet_at(0).text(0x54, 0x1001, "CS", "CNTS")).find("'CNTS'") !=
              std::string::npos);
        CHECK(reason_of(pet_at(0).text(8, 0x31, "TM", "120000")).find("processed") !=
              std::string::npos);
        CHECK(reason_of(pet_at(0).text(8, 0x31, "TM", "2560")).find("time '2560' (0008,0031)") !=
              std::string::npos);
        CHECK(reason_of(pet_at(0).text(8, 0x21, "DA", "20230229")).find("date '20230229'") !=
              std::string::npos);
        DicomSet later = tracer();
        later.text(0x18, 0x1078, "DT", "20240229110000");
        CHECK(reason_of(pet_at(0).sequence(0x54, 0x16, {later})).starts_with("the injection"));
    }

    TEST_CASE("slices of one series must agree about uptake, and the middle one has the window") {
        const TemporaryFolder folder;
        for (int z = 0; z < 3; ++z) {
            DicomSet set = pet_at(z);
            set.text(0x28, 0x1050, "DS", std::to_string(z)).text(0x28, 0x1051, "DS", "10");
            folder.write(std::to_string(z) + ".dcm", set.file());
        }
        const Volume volume = import_volume(folder.file(""));
        CHECK(volume.windows == std::vector<NamedWindow>{{"", 10, 1}});
        CHECK(volume.suv_per_value == doctest::Approx(expected_suv).epsilon(1e-12));
        DicomSet other = pet_at(3);
        folder.write("3.dcm", other.text(0x10, 0x1030, "DS", "51").file());
        const Volume mixed = import_volume(folder.file(""));
        CHECK(mixed.suv_per_value == 0);
        CHECK(mixed.unit == "Bq/ml");
        CHECK(std::ranges::any_of(mixed.findings, [](const Finding& finding) {
            return finding.text.ends_with(
                "slices differ: 3.dcm: a value of 1 Bq/ml is 0.00051 "
                "g/ml; 2.dcm: a value of 1 Bq/ml is 0.0005 g/ml");
        }));
    }
}
