#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <set>

#include "host/scene/marks_messages.hpp"
#include "host/scene/overlay.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

const Subject subject{{10, -20, 30}, 100};

Overlay overlay_of(const char* view, Size size = {512, 512}) {
    return {
        {find_view(view).value(), 1}, subject, size, {0, 0, 0, 255}, {}, {}, true, false, false};
}

/// The texts at the picture's left, right, top and bottom.
std::vector<std::string> sides_of(const Overlay& overlay) {
    std::vector<std::string> texts;
    for (const PictureMark& mark : overlay_marks(overlay)) {
        texts.push_back(mark.text);
    }
    return texts;
}

using Sides = std::vector<std::string>;

/// Pixels between two points of the patient in the picture.
double distance_px(const Camera& camera, Size size, glm::dvec3 a_mm, glm::dvec3 b_mm) {
    const CameraMatrices m =
        camera_matrices(camera, subject, static_cast<double>(size.width) / size.height);
    const auto pixel = [&](glm::dvec3 p_mm) {
        const glm::dvec4 clip = m.projection * m.patient_to_eye * glm::dvec4(p_mm, 1);
        return glm::dvec2(clip.x / clip.w * size.width / 2, clip.y / clip.w * size.height / 2);
    };
    return glm::distance(pixel(a_mm), pixel(b_mm));
}

struct TextBox {
    double left, right, top, bottom;
};

/// A little more than a text takes: DejaVu Sans' letters are 0.62 of their size wide on average,
/// capital ones 0.71.
TextBox box_of(const PictureMark& mark) {
    double width = 0;
    for (const char letter : mark.text) {
        width += mark.height_px * (letter >= 'A' && letter <= 'Z' ? 0.71 : 0.62);
    }
    const double left = mark.points[0].x - width * mark.align_x;
    const double top = mark.points[0].y - mark.height_px * mark.align_y;
    return {left, left + width, top, top + mark.height_px};
}

bool overlap(const TextBox& a, const TextBox& b) {
    return a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
}

}  // namespace

TEST_SUITE("host/scene/overlay") {
    TEST_CASE("the letters at the sides are those of clinical viewers") {
        // From in front the patient's right is on the left; axial pictures show anterior at the
        // top and are seen from the feet.
        CHECK(sides_of(overlay_of("anterior")) == Sides{"R", "L", "S", "I"});
        CHECK(sides_of(overlay_of("posterior")) == Sides{"L", "R", "S", "I"});
        CHECK(sides_of(overlay_of("left")) == Sides{"A", "P", "S", "I"});
        CHECK(sides_of(overlay_of("right")) == Sides{"P", "A", "S", "I"});
        CHECK(sides_of(overlay_of("inferior")) == Sides{"R", "L", "A", "P"});
        CHECK(sides_of(overlay_of("superior"))[2] == "A");
    }

    TEST_CASE("between two axes a side has the letters of both, the nearer first") {
        Overlay overlay = overlay_of("anterior");
        overlay.camera.angles = {30, 0};  // The right side points to (cos 30, sin 30, 0).
        CHECK(sides_of(overlay) == Sides{"RA", "LP", "S", "I"});
        overlay.camera.angles = {60, 0};
        CHECK(sides_of(overlay) == Sides{"AR", "PL", "S", "I"});
        overlay.camera.angles = {22, 0};
        CHECK(sides_of(overlay) == Sides{"R", "L", "S", "I"});
        overlay.camera.angles = {0, 45};
        CHECK(sides_of(overlay) == Sides{"R", "L", "PS", "AI"});
    }

    TEST_CASE("a roll of 90 degrees takes the letters round, a pan leaves them") {
        Overlay overlay = overlay_of("anterior");
        overlay.camera.pan_mm = {40, -30};
        CHECK(sides_of(overlay) == Sides{"R", "L", "S", "I"});
        overlay.camera.roll_deg = 90;  // What was above is at the left.
        CHECK(sides_of(overlay) == Sides{"S", "I", "L", "R"});
    }

    TEST_CASE("a direction's letters do not depend on its length, nor on how ties were rounded") {
        CHECK(direction_letters({0, 0, -0.001}) == "I");
        CHECK(direction_letters({-1, -1, 1}) == "RAS");
        CHECK(direction_letters({std::nextafter(5.0, 6.0), 5, 0}) == "LP");
        CHECK(direction_letters({5, std::nextafter(5.0, 6.0), 0}) == "LP");
        CHECK(direction_letters({0, 0, 0}).empty());
    }

    TEST_CASE("the scale bar is a round length and as long as that at the subject's center") {
        const glm::dvec3 c = subject.center_mm;
        for (const double zoom : {0.2, 0.37, 1.0, 3.3, 40.0}) {
            for (const Size size : {Size{512, 512}, Size{1600, 1200}, Size{300, 900}}) {
                CAPTURE(zoom);
                CAPTURE(size.width);
                const Camera camera{{0, 0}, zoom};
                const double most_px = size.width * 0.25;
                const ScaleBar bar = scale_bar(camera, subject, size, most_px);
                CHECK(bar.length_px <= most_px);
                CHECK(bar.length_px > most_px * 0.4 - 1e-6);  // 2 to 5 is the widest step.
                const double power = std::pow(10.0, std::floor(std::log10(bar.length_mm) + 1e-9));
                const double lead = bar.length_mm / power;
                const bool round = std::abs(lead - 1) < 1e-9 || std::abs(lead - 2) < 1e-9 ||
                                   std::abs(lead - 5) < 1e-9;
                CHECK(round);
                CHECK(distance_px(camera, size, c, c + glm::dvec3(bar.length_mm / 2, 0, 0)) * 2 ==
                      doctest::Approx(bar.length_px));
            }
        }
    }

    TEST_CASE("all marks lie within the picture, and small pictures have none") {
        Overlay overlay = overlay_of("anterior");
        overlay.directions = overlay.scale = true;
        overlay.caption.title = "a volume";
        for (int line = 0; line < 20; ++line) {
            overlay.legend.push_back({{200, 100, 50, 255}, "surface " + std::to_string(line)});
        }
        for (const Size size :
             {Size{96, 96}, Size{128, 300}, Size{512, 512}, Size{1600, 1200}, Size{4096, 4096}}) {
            CAPTURE(size.width);
            overlay.size = size;
            const std::vector<PictureMark> marks = overlay_marks(overlay);
            // Four letters and the bar's three marks, and with room for more, more.
            CHECK((marks.size() == 7) == (std::min(size.width, size.height) < 200));
            for (const PictureMark& mark : marks) {
                for (const glm::vec2& p : mark.points) {
                    CHECK(p.x >= 0);
                    CHECK(p.y >= 0);
                    CHECK(p.x <= static_cast<float>(size.width));
                    CHECK(p.y <= static_cast<float>(size.height));
                }
            }
        }
        overlay.size = {95, 400};
        CHECK(overlay_marks(overlay).empty());
    }

    TEST_CASE("the legend names every surface, and counts those for which there is no room") {
        Scene scene;
        for (int i = 0; i < 11; ++i) {
            Surface surface;
            surface.name = "s" + std::to_string(i);
            surface.isovalue = 100.5 + i;
            scene.surfaces.push_back(surface);
        }
        Surface hidden;
        hidden.name = "hidden";
        hidden.visible = false;
        scene.surfaces.insert(scene.surfaces.begin(), hidden);
        std::multiset<std::string> texts;
        for (const PictureMark& mark : overlay_marks(scene, subject, {"pelvis", ""})) {
            texts.insert(mark.text);
        }
        CHECK(texts.count("pelvis") == 1);
        CHECK(texts.count("s0  100.5") == 1);
        CHECK(texts.count("s7  107.5") == 1);
        CHECK(texts.count("s8  108.5") == 0);
        CHECK(texts.count("and 3 more") == 1);
        // 100 / sin 15 away, 2 * tan 15 / 1.3 times that across: 159 mm, a quarter of which is 40.
        CHECK(texts.count("20 mm") == 1);
    }

    TEST_CASE("letters are light over a dark background and dark over a light one") {
        for (const auto& [gray, is_light] : {std::pair(20, true), std::pair(250, false)}) {
            Overlay overlay = overlay_of("anterior");
            const auto value = static_cast<std::uint8_t>(gray);
            overlay.background = {value, value, value, 255};
            for (const PictureMark& mark : overlay_marks(overlay)) {
                CHECK((mark.color.g > 128) == is_light);
                CHECK(mark.width_px > 1);  // The halo.
            }
        }
    }

    TEST_CASE("a long title is cut between characters") {
        Overlay overlay = overlay_of("anterior", {200, 200});
        overlay.letters = false;
        for (int i = 0; i < 100; ++i) {
            overlay.caption.title += "ä";
        }
        const std::vector<PictureMark> marks = overlay_marks(overlay);
        REQUIRE(marks.size() == 1);
        const std::string& text = marks[0].text;
        CHECK(text.size() < 100);
        CHECK(text.ends_with("ä…"));
        CHECK(text.find("ä") == 0);
    }

    TEST_CASE("a warning is whole in pictures of any size, and lies over no other text") {
        Overlay overlay = overlay_of("anterior");
        overlay.camera.angles = {30, 20};  // Two letters at each side.
        overlay.directions = overlay.scale = true;
        const std::string name = "a long name of a volume";
        for (const Size size :
             {Size{96, 96}, Size{96, 400}, Size{150, 150}, Size{200, 200}, Size{256, 256},
              Size{300, 200}, Size{512, 512}, Size{1280, 1280}, Size{1920, 1080}}) {
            CAPTURE(size.width);
            overlay.size = size;
            overlay.caption = {name, ""};
            const std::vector<PictureMark> without = overlay_marks(overlay);
            overlay.caption.warning = "place or spacing ASSUMED";
            const std::vector<PictureMark> with = overlay_marks(overlay);
            REQUIRE(with.size() > without.size());
            std::vector<PictureMark> lines, others;
            for (const PictureMark& mark : with) {
                const bool is_other = std::ranges::any_of(without, [&](const PictureMark& each) {
                    return each.kind == mark.kind && each.points == mark.points &&
                           each.text == mark.text;
                });
                (is_other ? others : lines).push_back(mark);
            }
            CHECK(others.size() == without.size());
            std::string read;
            for (const PictureMark& line : lines) {
                read += (read.empty() ? "" : " ") + line.text;
                const TextBox box = box_of(line);
                CHECK(box.left >= 0);
                CHECK(box.right <= size.width);
                CHECK(box.bottom <= size.height);
                CHECK(line.height_px >= 9);
                for (const PictureMark& other : with) {
                    if (&other != &line && other.kind == MarkKind::text &&
                        other.text != line.text) {
                        CHECK_MESSAGE(!overlap(box, box_of(other)),
                                      line.text << " over " << other.text);
                    }
                }
            }
            CHECK(read == "place or spacing ASSUMED");
        }
    }

    TEST_CASE("marks cross the ring as they are") {
        const std::vector<PictureMark> marks = {
            line_mark({{1, 2}, {3, 4}}, {1, 2, 3, 4}, 5),
            area_mark({{0, 0}, {1, 0}, {0, 1}}, {9, 8, 7, 6}),
            text_mark({7, 8}, "50 mm", {5, 6, 7, 8}, {20, 0.5F, 1, 3})};
        const auto wire = marks_message(marks);
        REQUIRE(wire.size() == 3);
        CHECK(wire[0]->kind == MarkKind::line);
        CHECK(wire[0]->width_px == 5);
        CHECK(wire[0]->points[1].x() == 3);
        CHECK(wire[0]->points[1].y() == 4);
        CHECK(wire[1]->kind == MarkKind::area);
        CHECK(wire[1]->points.size() == 3);
        CHECK(wire[1]->color->r() == 9);
        CHECK(wire[1]->color->a() == 6);
        CHECK(wire[2]->kind == MarkKind::text);
        CHECK(wire[2]->text == "50 mm");
        CHECK(wire[2]->height_px == 20);
        CHECK(wire[2]->align_x == 0.5F);
        CHECK(wire[2]->align_y == 1);
        CHECK(wire[2]->width_px == 3);
    }
}
