// Time series of DICOM: slices of one place that follow each other in time.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <functional>

#include "host/io/import.hpp"
#include "tests/host/io/dicom_files.hpp"
#include "tests/host/io/formats/read_frame.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

constexpr int frames = 3, places = 2, voxels = 4;  // Slices of 2x2 voxels.

/// A slice that holds 100 x the volume's number + its place.
DicomSet slice(int frame, int place) {
    const auto value = static_cast<std::int16_t>(100 * frame + place);
    DicomSet set = dicom_image(2, 2, bytes_of(std::vector<std::int16_t>(voxels, value)));
    return dicom_place(set, {0, 0, 5.0 * place}, {1, 0, 0}, {0, 1, 0}, 1, 1);
}

/// Adds to slice `place` of volume `frame`, from 0 and 1, what tells its time.
using TellTime = std::function<void(DicomSet&, int frame, int place)>;

/// A folder with the slices of a series, whose names and instance numbers say nothing about time.
void write_series(const TemporaryFolder& folder, const TellTime& tell) {
    for (int frame = 1; frame <= frames; ++frame) {
        for (int place = 0; place < places; ++place) {
            DicomSet set = slice(frame, place);
            const int number = 7 * (frame * places + place) % 13;
            set.text(0x20, 0x13, "IS", std::to_string(number));
            tell(set, frame, place);
            folder.write("IM" + std::to_string(number), set.file());
        }
    }
}

std::vector<int> values_of(const Volume& volume) {
    std::vector<std::int16_t> values(volume.values.size() / 2);
    std::memcpy(values.data(), volume.values.data(), volume.values.size());
    return {values.begin(), values.end()};
}

std::vector<int> expected(int frame) {
    std::vector<int> values(voxels, 100 * frame);
    values.insert(values.end(), voxels, 100 * frame + 1);
    return values;
}

bool reports(const Volume& volume, FindingKind kind, const std::string& words) {
    return std::ranges::any_of(volume.findings, [&](const Finding& finding) {
        return finding.kind == kind && finding.text.find(words) != std::string::npos;
    });
}

/// Each volume of the series in order, and nothing reported as a copy.
void check_series(const std::string& path, const std::string& told_by, double frame_ms) {
    CHECK(values_of(read_frame(path, 0)) == expected(1));
    for (int frame = 1; frame <= frames; ++frame) {
        CAPTURE(frame);
        const Volume volume = read_frame(path, static_cast<std::uint32_t>(frame));
        CHECK(values_of(volume) == expected(frame));
        CHECK(volume.frame == frame);
        CHECK(volume.frames == frames);
        CHECK(volume.frame_ms == frame_ms);
        CHECK(volume.voxel_to_patient[2] == glm::dvec4(0, 0, 5, 0));
        CHECK(reports(volume, FindingKind::note,
                      "volume " + std::to_string(frame) + " of 3 of a time series: " + told_by +
                          " tells them apart"));
        CHECK(!reports(volume, FindingKind::duplicate_slices, ""));
    }
    CHECK_THROWS_WITH_AS(
        read_frame(path, 4),
        (path + ": frame is 4, but the series has 3 volumes: give frame=1 to 3").c_str(),
        ImportError);
}

/// The volumes are read in turn, and the headers of the folder only with the first of them.
void check_turn(const TemporaryFolder& folder) {
    ImportRequest request;
    request.path = folder.file("");
    Importer importer(request);
    CHECK(values_of(importer.read(1, true)) == expected(1));
    DicomSet other = slice(4, 0);
    other.text(0x20, 0x13, "IS", "99");
    folder.write("IM99", other.file());
    CHECK(values_of(importer.read(3, true)) == expected(3));
    CHECK(values_of(importer.read(2)) == expected(2));
    CHECK(read_frame(folder.file(""), 0).frames == 1);  // Which now has a slice more.
}

/// One volume: at each place that of the lowest instance number, and the others are named.
void check_copies(const std::string& why, const TellTime& tell) {
    CAPTURE(why);
    const TemporaryFolder folder;
    write_series(folder, tell);
    const Volume volume = read_frame(folder.file(""), 0);
    CHECK(volume.frames == 1);
    CHECK(reports(volume, FindingKind::duplicate_slices, "have the position of another"));
    CHECK_THROWS_WITH_AS(read_frame(folder.file(""), 2),
                         (folder.file("") + ": frame is 2, but the series has one volume (" + why +
                          "): load it without frame=")
                             .c_str(),
                         ImportError);
}

constexpr const char* differ = "slices of one place differ in more than their time";
constexpr const char* untold = "no element of time tells the slices of each place apart";

void check_told(const std::string& told_by, double frame_ms, const TellTime& tell) {
    CAPTURE(told_by);
    const TemporaryFolder folder;
    write_series(folder, tell);
    check_series(folder.file(""), told_by, frame_ms);
}

void trigger(DicomSet& set, double ms) {
    set.text(0x18, 0x1060, "DS", dicom_numbers({ms}));
}

/// A file with all slices as frames, the last volume first. `tell` fills a functional group:
/// (0020,9111), the frame's content, or (0018,9118), the heart's clock.
DicomSet enhanced(std::uint16_t macro, const std::function<void(DicomSet&, int frame)>& tell) {
    std::vector<DicomSet> groups;
    std::string values;
    for (int frame = frames; frame >= 1; --frame) {
        for (int place = 0; place < places; ++place) {
            values += bytes_of(
                std::vector<std::int16_t>(voxels, static_cast<std::int16_t>(100 * frame + place)));
            DicomSet position, told, group;
            tell(told, frame);
            group.sequence(macro == 0x9118 ? 0x18 : 0x20, macro, {told});
            position.text(0x20, 0x32, "DS", dicom_numbers({0, 0, 5.0 * place}));
            groups.push_back(group.sequence(0x20, 0x9113, {position}));
        }
    }
    DicomSet orientation, measures, shared;
    orientation.text(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0");
    measures.text(0x28, 0x30, "DS", "1\\1");
    shared.sequence(0x20, 0x9116, {orientation}).sequence(0x28, 0x9110, {measures});
    DicomSet set = dicom_image(2, 2, values);
    set.text(0x28, 8, "IS", std::to_string(groups.size()));
    return set.sequence(0x5200, 0x9229, {shared}).sequence(0x5200, 0x9230, groups);
}

}  // namespace

TEST_SUITE("host/io/dicom_time") {
    TEST_CASE("each element of time puts the slices of a place in order") {
        check_told("Temporal Position", 0, [](DicomSet& set, int frame, int) {
            set.text(0x20, 0x100, "IS", std::to_string(frame));
        });
        check_told("Trigger Time", 33.5,
                   [](DicomSet& set, int frame, int) { trigger(set, 12 + 33.5 * frame); });
        check_told("Acquisition Time", 1500, [](DicomSet& set, int frame, int) {
            constexpr std::array times = {"095958.5", "100000", "100001.500000"};
            set.text(8, 0x32, "TM", times[static_cast<std::size_t>(frame - 1)]);
        });
        check_told("Acquisition Time", 2000, [](DicomSet& set, int frame, int) {
            set.text(8, 0x32, "TM", "23:01:0" + std::to_string(2 * frame));
        });
        check_told("Acquisition Number", 0, [](DicomSet& set, int frame, int) {
            set.text(0x20, 0x12, "IS", "+" + std::to_string(10 * frame));
        });
    }

    TEST_CASE("volumes that are read in turn share the headers of their files") {
        const TemporaryFolder folder;
        write_series(folder, [](DicomSet& set, int frame, int) { trigger(set, 40.0 * frame); });
        check_turn(folder);
    }

    TEST_CASE("a number in time counts more than a clock, which still tells the step") {
        check_told("Temporal Position", 40, [](DicomSet& set, int frame, int) {
            trigger(set, 40 * frame);
            set.text(0x20, 0x100, "IS", std::to_string(frame));
        });
    }

    TEST_CASE("slices of a volume need not have the same time, as one is acquired after another") {
        check_told("Trigger Time", 30, [](DicomSet& set, int frame, int place) {
            trigger(set, 30 * frame + 100 * place);
        });
    }

    TEST_CASE("uneven times are those of each volume") {
        const TellTime tell = [](DicomSet& set, int frame, int) {
            trigger(set, 10 * frame * frame);
        };
        check_told("Trigger Time", 0, tell);
        const TemporaryFolder folder;
        write_series(folder, tell);
        CHECK(read_frame(folder.file(""), 2).times_ms == std::vector<double>{0, 30, 80});
    }

    TEST_CASE("times that make no sense count as absent, and the next element is taken") {
        check_told("Acquisition Number", 0, [](DicomSet& set, int frame, int) {
            set.text(0x18, 0x1060, "DS", "soon").text(0x20, 0x100, "IS", "1\\2");
            set.text(8, 0x32, "TM", "99999" + std::to_string(frame));
            set.text(0x20, 0x12, "IS", std::to_string(frame));
        });
    }

    TEST_CASE("slices that differ in more than time are copies, as are those of the same time") {
        const std::vector<TellTime> kinds = {
            [](DicomSet& set, int frame, int) {  // Echo time.
                set.text(0x18, 0x81, "DS", std::to_string(5 * frame));
            },
            [](DicomSet& set, int frame, int) {  // Inversion time.
                set.text(0x18, 0x82, "DS", std::to_string(100 * frame));
            },
            [](DicomSet& set, int frame, int) {  // Diffusion weight.
                set.put(0x18, 0x9087, "FD", bytes_of(500.0 * frame));
            },
            [](DicomSet& set, int frame, int) {  // Diffusion direction.
                set.put(0x18, 0x9089, "FD", bytes_of(std::vector<double>{1.0 * frame, 0, 0}));
            },
            [](DicomSet& set, int frame, int) {  // Sequence.
                set.text(0x18, 0x24, "SH", "*ep_b" + std::to_string(500 * frame));
            },
            [](DicomSet& set, int frame, int) {  // Phases beside magnitudes.
                set.text(8, 8, "CS", frame == 2 ? "ORIGINAL\\PRIMARY\\P" : "ORIGINAL\\PRIMARY\\M");
            }};
        for (const TellTime& kind : kinds) {
            check_copies(differ, [&](DicomSet& set, int frame, int place) {
                trigger(set, 30 * frame);
                kind(set, frame, place);
            });
        }
        check_copies(
            "slices of one place are shifted sideways", [](DicomSet& set, int frame, int place) {
                trigger(set, 30 * frame);
                dicom_place(set, {3.0 * frame, 0, 5.0 * place}, {1, 0, 0}, {0, 1, 0}, 1, 1);
            });
        check_copies(untold,
                     [](DicomSet& set, int frame, int) { trigger(set, frame == 1 ? 10 : 20); });
        check_copies("the number of slices differs from place to place",
                     [](DicomSet& set, int frame, int place) {
                         trigger(set, 30 * frame);
                         if (frame == 3 && place == 1) {
                             dicom_place(set, {0, 0, 10}, {1, 0, 0}, {0, 1, 0}, 1, 1);
                         }
                     });
        check_copies(untold, [](DicomSet& set, int frame, int place) {
            if (frame != 2 || place != 1) {
                trigger(set, 30 * frame);
            }
        });
    }

    TEST_CASE("midnight and a time zone do not change the order") {
        static constexpr std::array times = {"20261128235958.5+0100", "20261129000000.0+0100",
                                             "20261129000001.5+0100"};
        check_told("Acquisition Time", 1500, [](DicomSet& set, int frame, int) {
            const std::string text = times[static_cast<std::size_t>(frame - 1)];
            set.text(8, 0x22, "DA", text.substr(0, 8)).text(8, 0x32, "TM", text.substr(8, 8));
        });
        check_told("Acquisition Time", 1500, [](DicomSet& set, int frame, int) {
            set.text(8, 0x2a, "DT", times[static_cast<std::size_t>(frame - 1)]);
        });
    }

    TEST_CASE("of contrast medium, one image a beat, the wall's clock tells the order") {
        check_told("Acquisition Time", 1000, [](DicomSet& set, int frame, int) {
            constexpr std::array delays_ms = {112.5, 107.5, 115.0};
            trigger(set, delays_ms[static_cast<std::size_t>(frame - 1)]);
            set.text(8, 0x32, "TM", "10000" + std::to_string(frame));
        });
    }

    TEST_CASE("all volumes have the place of the first, though positions have few digits") {
        const TemporaryFolder folder;
        write_series(folder, [](DicomSet& set, int frame, int place) {
            trigger(set, 30 * frame);
            dicom_place(set, {0.001 * frame, 0, 5.0 * place + 0.0002 * frame}, {1, 0, 0}, {0, 1, 0},
                        1, 1);
        });
        const Volume first = read_frame(folder.file(""), 1);
        for (int frame = 2; frame <= frames; ++frame) {
            const Volume volume = read_frame(folder.file(""), static_cast<std::uint32_t>(frame));
            CHECK(values_of(volume) == expected(frame));
            CHECK(volume.voxel_to_patient == first.voxel_to_patient);
            CHECK(volume.slice_places == first.slice_places);
        }
    }

    TEST_CASE("a file of a later volume that cannot be decoded is named") {
        const TemporaryFolder folder;
        write_series(folder, [](DicomSet& set, int frame, int place) {
            trigger(set, 30 * frame);
            if (frame == 2 && place == 1) {
                set.compressed_pixels("no picture");
            }
        });
        CHECK_THROWS_WITH_AS(read_frame(folder.file(""), 2), doctest::Contains("IM9: "),
                             ImportError);
    }

    TEST_CASE("frames of an enhanced file are told apart by their groups' elements") {
        const TemporaryFolder folder;
        const auto check = [&](const std::string& told_by, double frame_ms, std::uint16_t macro,
                               const std::function<void(DicomSet&, int frame)>& tell) {
            check_series(folder.write("x.dcm", enhanced(macro, tell).file()), told_by, frame_ms);
        };
        check("Temporal Position", 0, 0x9111, [](DicomSet& content, int frame) {
            content.put(0x20, 0x9128, "UL", bytes_of(static_cast<std::uint32_t>(frame)));
        });
        check("Trigger Time", 25, 0x9118, [](DicomSet& heart, int frame) {
            heart.put(0x20, 0x9153, "FD", bytes_of(25.0 * frame));
        });
        check("Acquisition Time", 1000, 0x9111, [](DicomSet& content, int frame) {
            content.text(0x18, 0x9074, "DT", "2026112810000" + std::to_string(frame) + ".5");
        });
        check("Acquisition Number", 0, 0x9111, [](DicomSet& content, int frame) {
            content.put(0x20, 0x9156, "US", bytes_of(static_cast<std::uint16_t>(frame)));
        });
        const DicomSet too_short = enhanced(0x9111, [](DicomSet& content, int frame) {
            content.put(0x20, 0x9128, "UL", bytes_of(static_cast<std::uint16_t>(frame)));
        });
        CHECK(read_frame(folder.write("short.dcm", too_short.file()), 0).frames == 1);
    }

    TEST_CASE("mosaics, one file a volume, are a time series") {
        const TemporaryFolder folder;
        for (int frame = 1; frame <= frames; ++frame) {
            folder.write("M" + std::to_string(9 - frame),
                         mosaic()
                             .text(0x20, 0x12, "IS", std::to_string(frame))
                             .text(8, 0x32, "TM", "10000" + std::to_string(2 * frame))
                             .text(0x28, 0x1053, "DS", std::to_string(frame))
                             .text(0x28, 0x1052, "DS", "0")
                             .file());
        }
        for (int frame = 1; frame <= frames; ++frame) {
            const Volume volume = read_frame(folder.file(""), static_cast<std::uint32_t>(frame));
            CHECK(volume.nz == 3);
            CHECK(volume.frames == frames);
            CHECK(volume.frame_ms == 2000);
            CHECK(values_of(volume).back() == 25 * frame);
        }
    }

    TEST_CASE("GPs read the same volume of the series as the host") {
        const TemporaryFolder folder;
        write_series(folder, [](DicomSet& set, int frame, int) { trigger(set, 30 * frame); });
        const Volume volume = read_frame(folder.file(""), 2, ReadBy::gps);
        REQUIRE(volume.stored);
        CHECK(volume.frame == 2);
        CHECK(volume.minimum == 200);
        CHECK(volume.maximum == 201);
    }
}
