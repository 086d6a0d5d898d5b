#include <doctest/doctest.h>

#include <string>
#include <variant>

#include "host/report/headset_text.hpp"

using namespace pxpl5::host;
using namespace pxpl5::host::report;

namespace {

timing::HeadsetTime time_of_bone() {
    timing::HeadsetTime time;
    time.rate.frames_per_s = 8.64;
    time.rate.limit = timing::Unit::gp;
    time.drawn_ms = 230.4;
    time.least_ms = 275.4;
    time.most_ms = 315.4;
    return time;
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST_SUITE("host/report/headset_text") {
    TEST_CASE("a line has rate, limit, drawing and latency, and the parts of it are explained") {
        const std::string text = text_of({{"pelvis/bone", time_of_bone()}}, {});
        CHECK_MESSAGE(has(text, "pelvis/bone       8.6     GP        230   275 to 315\n"), text);
        CHECK_MESSAGE(has(text, "640 x 512 pixels for each eye"), text);
        CHECK_MESSAGE(has(text,
                          "tracker's 20 to 60 ms, drawn, 8.3 ms for the field on average, "
                          "and 16.7 ms of scan-out"),
                      text);
    }

    TEST_CASE("each number of the display is told with value, unit, provenance and source") {
        const std::string text = text_of({}, {});
        const std::vector<Fields> list = fields_of(timing::Headset{});
        REQUIRE(list.size() == timing::headset_rows().size());
        for (const Fields& fields : list) {
            REQUIRE(fields.size() == 5);
            const auto word = [&](std::size_t at) {
                return std::get<std::string>(fields[at].value);
            };
            CHECK_MESSAGE(has(text, word(0)), word(0));
            CHECK((word(3) == "published" || word(3) == "derived" || word(3) == "ours"));
            CHECK_MESSAGE(has(text, word(4)), word(4));
        }
        CHECK(has(text, "Ward et al. 1992"));
    }

    TEST_CASE("the fields of a row end with those of the display") {
        Fields fields{{"row", std::string("pelvis/bone")}};
        add_fields(time_of_bone(), fields);
        REQUIRE(fields.size() == 6);
        CHECK(fields[1].name == "stereo_frames_per_s");
        CHECK(std::get<double>(fields[1].value) == 8.64);
        CHECK(std::get<std::string>(fields[2].value) == "GP");
        CHECK(std::get<double>(fields[5].value) == 315.4);
    }
}
