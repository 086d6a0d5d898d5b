// Time series of DICOM with missing slices.
#include <doctest/doctest.h>

#include <algorithm>
#include <functional>

#include "host/io/import.hpp"
#include "tests/host/io/dicom_files.hpp"
#include "tests/host/io/formats/read_frame.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

/// Writes a series of slices of 2x2 voxels, which hold the volume's number, at times 30 ms apart.
///
/// is_there  Whether slice `place` of volume `frame`, from 0 and 1, is written.
void write_series(const TemporaryFolder& folder, int frames, int places, bool with_number,
                  const std::function<bool(int frame, int place)>& is_there) {
    for (int frame = 1; frame <= frames; ++frame) {
        const auto value = static_cast<std::int16_t>(frame);
        for (int place = 0; place < places; ++place) {
            if (!is_there(frame, place)) {
                continue;
            }
            DicomSet set = dicom_image(2, 2, bytes_of(std::vector<std::int16_t>(4, value)));
            dicom_place(set, {0, 0, 5.0 * place}, {1, 0, 0}, {0, 1, 0}, 1, 1);
            if (with_number) {
                set.text(0x20, 0x100, "IS", std::to_string(frame));
            } else {
                set.text(0x18, 0x1060, "DS", std::to_string(30 * frame));
            }
            folder.write("IM" + std::to_string(10 * frame + place), set.file());
        }
    }
}

/// The number that all voxels of a volume hold.
int number_of(const Volume& volume) {
    const int number = std::to_integer<int>(volume.values.at(0));
    for (std::size_t i = 0; i < volume.values.size(); i += 2) {
        CHECK(std::to_integer<int>(volume.values[i]) == number);
    }
    return number;
}

/// Texts of the findings of a kind.
std::vector<std::string> texts_of(const Volume& volume, FindingKind kind) {
    std::vector<std::string> texts;
    for (const Finding& finding : volume.findings) {
        if (finding.kind == kind) {
            texts.push_back(finding.text);
        }
    }
    return texts;
}

}  // namespace

TEST_SUITE("host/io/lost DICOM slices") {
    TEST_CASE("incomplete volumes are left out, and named") {
        const TemporaryFolder folder;
        // Each place lacks another volume, so that all places have as many slices.
        write_series(folder, 4, 2, true, [](int frame, int place) { return frame != 2 + place; });
        for (const auto& [number, frame] : {std::pair{1, 1}, {2, 4}}) {
            const Volume volume = read_frame(folder.file(""), static_cast<std::uint32_t>(number));
            CHECK(volume.frames == 2);
            CHECK(number_of(volume) == frame);
            CHECK(texts_of(volume, FindingKind::missing_volumes) ==
                  std::vector<std::string>{
                      "2 slices are left out, because their volumes are not whole: volume 2 of 4 "
                      "(Temporal Position 2) has 1 of 2 slices; volume 3 of 4 (Temporal Position "
                      "3) has 1 of 2 slices"});
        }
    }

    TEST_CASE("a lost slice costs its volume, and the other volumes keep their times") {
        for (const int lost : {1, 3}) {
            CAPTURE(lost);
            const TemporaryFolder folder;
            write_series(folder, 4, 3, false,
                         [&](int frame, int place) { return frame != lost || place != 1; });
            const Volume first = read_frame(folder.file(""), 0);
            CHECK(first.frames == 3);
            CHECK(number_of(first) == (lost == 1 ? 2 : 1));
            CHECK(number_of(read_frame(folder.file(""), 3)) == 4);
            CHECK(texts_of(first, FindingKind::duplicate_slices).empty());
            const std::string why = texts_of(first, FindingKind::missing_volumes).at(0);
            if (lost == 1) {
                CHECK(why ==
                      "2 slices are left out, because their volumes are not whole: volume 1 of 4 "
                      "(Trigger Time 30) has 2 of 3 slices; times count from the first whole "
                      "volume");
                CHECK(first.frame_ms == 30);
                CHECK(first.times_ms.empty());
            } else {
                CHECK(why ==
                      "2 slices are left out, because their volumes are not whole: volume 3 of 4 "
                      "(Trigger Time 90) has 2 of 3 slices");
                CHECK(first.frame_ms == 0);
                CHECK(first.times_ms == std::vector<double>{0, 30, 90});
            }
        }
    }

    TEST_CASE("without times, a finding about the first volume says nothing of times") {
        const TemporaryFolder folder;
        write_series(folder, 4, 3, true, [](int frame, int place) { return frame + place != 1; });
        const Volume first = read_frame(folder.file(""), 0);
        CHECK(number_of(first) == 2);
        CHECK(
            texts_of(first, FindingKind::missing_volumes) ==
            std::vector<std::string>{"2 slices are left out, because their volumes are not whole: "
                                     "volume 1 of 4 (Temporal Position 1) has 2 of 3 slices"});
    }

    TEST_CASE("if a slice of most volumes is missing, one volume is shown, with the reason") {
        const TemporaryFolder folder;
        write_series(folder, 4, 4, false,
                     [](int frame, int place) { return frame == 4 || place != frame - 1; });
        const Volume volume = read_frame(folder.file(""), 0);
        CHECK(volume.frames == 1);
        const std::vector<std::string> texts = texts_of(volume, FindingKind::duplicate_slices);
        REQUIRE(texts.size() == 1);
        CHECK(texts[0].find("9 slices have the position of another and are left out (each position "
                            "occurs 3 to 4 times, but this is no time series: the number of "
                            "slices differs from place to place; the shown volume may mix them)") ==
              0);
    }
}
