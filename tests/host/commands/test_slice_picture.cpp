// Tests the texts about a slice's picture.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "host/chart/chart.hpp"
#include "host/commands/text/slice_picture.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

Surface named(const char* name, ComponentFilter::Kind kind) {
    Surface surface;
    surface.name = name;
    surface.components.kind = kind;
    return surface;
}

/// A slice of 4 x 4 equal values.
Slice flat_slice() {
    Slice slice;
    slice.type = Scalar::uint8;
    slice.frame.across.count = slice.frame.down.count = 4;
    slice.values.resize(16);
    return slice;
}

}  // namespace

TEST_CASE("a slice names the settings by which the 3D picture hides parts of its contours") {
    using enum ComponentFilter::Kind;
    const Surface whole = named("skin", all), part = named("bone", largest);
    const std::vector<ContourPiece> pieces(3);
    Scene scene;
    CHECK(hidden_in_3d(scene, {{&whole, pieces}}).empty());
    CHECK(hidden_in_3d(scene, {{&whole, pieces}, {&part, pieces}}) ==
          std::vector<std::string>{"components of bone"});
    for (const char* words : {"L 20", "box 0,0,0 9,9,9", "box 0,0,0 9,9,9"}) {
        scene.clips.push_back({words, {}});
    }
    CHECK(hidden_in_3d(scene, {{&whole, pieces}, {&part, pieces}}) ==
          std::vector<std::string>{"clip L 20", "clip box 0,0,0 9,9,9", "components of bone"});
    // Nothing is hidden where the slice shows no surface.
    CHECK(hidden_in_3d(scene, {{&part, {}}}).empty());
    CHECK(hidden_in_3d(scene, {}).empty());
}

TEST_CASE("uptake values decide a slice's window, then the file, then the kind of scan") {
    Volume volume;
    CHECK_FALSE(stated_window(volume));
    volume.modality = "CT";
    CHECK(stated_window(volume)->width == 400);
    CHECK(stated_window(volume)->level == 40);
    volume.windows = {{"lung", 1500, -600}, {"bone", 2000, 300}};
    CHECK(stated_window(volume)->width == 1500);
    CHECK(stated_window(volume)->level == -600);
    CHECK(usual_window(volume, {}).width == 1500);
    volume.suv_per_value = 0.001;
    CHECK(stated_window(volume)->width == doctest::Approx(10'000));
    CHECK(stated_window(volume)->level == doctest::Approx(5'000));
}

// The numbers are those of the viewer's test, tests/browser/slices/page_slices.test.js.
TEST_CASE("the window of other scans has most values without the air around a patient") {
    Volume volume;
    volume.modality = "US";
    volume.maximum = 255;
    const GrayWindow even = usual_window(volume, {0, 1, std::vector<std::uint64_t>(100, 10)});
    CHECK(even.width == doctest::Approx(96));
    CHECK(even.level == doctest::Approx(50));
    std::vector<std::uint64_t> counts(100, 10);
    counts.front() = 9000;
    counts.back() = 1;
    const GrayWindow most = usual_window(volume, {-0.5, 2, counts});
    CHECK(std::abs(most.level - most.width / 2 - 5.5) < 0.6);
    CHECK(std::abs(most.level + most.width / 2 - 193.5) < 0.6);
    for (const std::vector<std::uint64_t>& few :
         {std::vector<std::uint64_t>{5}, {0, 0, 7, 0}, {1, 1}, {0}, {}}) {
        const GrayWindow window = usual_window(volume, {10, 4, few});
        CHECK(window.width > 0);
        CHECK(std::isfinite(window.level));
    }
    volume.modality = "";
    CHECK_FALSE(stated_window(volume));
    volume.minimum = -1000;
    volume.maximum = 1494;  // Air and bone.
    CHECK(stated_window(volume)->level == 40);
    volume.modality = "MR";
    CHECK_FALSE(stated_window(volume));
}

TEST_CASE("the picture of a slice has the whole warning at any size") {
    const Slice slice = flat_slice();
    for (const int side : {96, 256, 512}) {
        const SlicePicture drawn =
            slice_picture(slice, {}, {1, 0}, {side, side}, {"a title", "place or spacing ASSUMED"});
        std::string read;
        for (const PictureMark& mark : drawn.marks) {
            const bool is_letter = mark.text == "a title" || mark.text.size() < 3;
            read += is_letter ? "" : (read.empty() ? "" : " ") + mark.text;
        }
        CHECK(read == "place or spacing ASSUMED");
    }
}

TEST_CASE("the picture of a slice has the whole title at any size") {
    const std::string title = "13/30, 360 ms: oblique 20 30 at (-12.34, 5.67, 8.90) mm, window 471";
    for (const int side : {96, 300, 1024}) {
        CAPTURE(side);
        const SlicePicture drawn =
            slice_picture(flat_slice(), {}, {1, 0}, {side, side}, {title, ""});
        std::vector<PictureMark> lines;
        for (const PictureMark& mark : drawn.marks) {
            if (mark.height_px == 12) {  // The letters of the sides are larger.
                lines.push_back(mark);
            }
        }
        // From the bottom upwards.
        std::ranges::sort(lines, {}, [](const PictureMark& mark) { return mark.points[0].y; });
        std::string read;
        for (const PictureMark& line : lines) {
            read += (read.empty() ? "" : " ") + line.text;
            CHECK(text_width(line.text, line.height_px) <= side - 16);
        }
        CHECK(read == title);
        CHECK((lines.size() == 1) == (side == 1024));
    }
}
