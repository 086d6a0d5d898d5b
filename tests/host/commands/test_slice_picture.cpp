// Tests the texts about a slice's picture.
#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

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
    CHECK(usual_window(volume).width == 1500);
    volume.suv_per_value = 0.001;
    CHECK(stated_window(volume)->width == doctest::Approx(10'000));
    CHECK(stated_window(volume)->level == doctest::Approx(5'000));
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
