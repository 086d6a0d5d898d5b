// Tests the inbox, the size of moving pictures and the viewers' messages.
#include <doctest/doctest.h>

#include <functional>

#include "host/base/error.hpp"
#include "host/serve/director/inbox.hpp"
#include "host/serve/director/pace.hpp"
#include "host/serve/director/viewer_message.hpp"

using namespace pxpl5::host;
using namespace pxpl5::host::serve;

namespace {

Inbox::Outcome add(Inbox& inbox, const std::string& line, std::uint32_t id = 0) {
    return inbox.add({1, id, false, line, parse_line(line)});
}

Inbox::Outcome ask(Inbox& inbox, std::uint32_t viewer, const std::string& kind,
                   const std::string& text) {
    return inbox.add({viewer, 7, true, text, {}, kind});
}

std::string taken(Inbox& inbox) {
    std::string lines;
    while (!inbox.empty()) {
        lines += inbox.take().text + ";";
    }
    return lines;
}

std::string error_of(const std::function<void()>& act) {
    try {
        act();
    } catch (const RequestError& error) {
        return error.what();
    }
    return "";
}

}  // namespace

TEST_SUITE("host/serve/inbox") {
    TEST_CASE("a newer setting takes the place of the older, which is named") {
        Inbox inbox;
        add(inbox, "surface bone iso=1", 11);
        add(inbox, "view 10 20", 12);
        const Inbox::Outcome outcome = add(inbox, "surface bone iso=2", 13);
        REQUIRE(outcome.superseded);
        CHECK(outcome.superseded->id == 11);
        CHECK(taken(inbox) == "view 10 20;surface bone iso=2;");
    }

    TEST_CASE("of settings of one parameter the latest wins, whatever words it was set with") {
        Inbox inbox;
        for (const char* line : {"view 10 0", "view anterior", "view 20 0", "view 40 7"}) {
            add(inbox, line);
        }
        CHECK(taken(inbox) == "view anterior;view 40 7;");
    }

    TEST_CASE("the setting that may add a surface stays before what follows it") {
        Inbox inbox;
        for (const char* line : {"surface new iso=1", "surface old iso=1", "surface new iso=2"}) {
            add(inbox, line);
        }
        CHECK(inbox.size() == 2);  // Nothing of `new` lay between.
        for (const char* line : {"components new show=all", "surface new iso=3",
                                 "surface new iso=4", "surface old iso=5"}) {
            add(inbox, line);
        }
        CHECK(taken(inbox) ==
              "surface new iso=2;components new show=all;surface new iso=4;"
              "surface old iso=5;");
    }

    TEST_CASE("an action or a question sees what was set before it, and not what was set after") {
        for (const char* between : {"snapshot a.png", "pick 1 2 set=bone", "clip off", "undo",
                                    "components bone at=1,2"}) {
            Inbox inbox;
            add(inbox, "surface bone iso=1");
            add(inbox, between);
            CHECK(!add(inbox, "surface bone iso=2").superseded);
            CHECK(add(inbox, "surface bone iso=3").superseded);
            CHECK(taken(inbox) ==
                  std::string("surface bone iso=1;") + between + ";surface bone iso=3;");
        }
    }

    TEST_CASE("settings of other things, and actions, wait for their turn") {
        Inbox inbox;
        for (const char* line : {"surface bone iso=1", "surface skin iso=1",
                                 "surface bone opacity=1", "remove bone", "remove bone"}) {
            CHECK(!add(inbox, line).superseded);
        }
        CHECK(inbox.size() == 5);
    }

    TEST_CASE("a question whose answer is bytes lets settings pass") {
        Inbox inbox;
        add(inbox, "surface bone iso=1");
        ask(inbox, 1, "slice x", "{}");
        CHECK(add(inbox, "surface bone iso=2").superseded);
        CHECK(inbox.size() == 2);
        inbox.forget_asks(1);
        CHECK(taken(inbox) == "surface bone iso=2;");
    }

    TEST_CASE("questions whose answers are bytes wait for commands, and for no other viewer's") {
        Inbox inbox;
        ask(inbox, 1, "slice x", "1 x 5");
        ask(inbox, 1, "slice y", "1 y 5");
        ask(inbox, 2, "slice x", "2 x 5");
        add(inbox, "view 1 1");
        CHECK(ask(inbox, 1, "slice x", "1 x 6").superseded.value_or(Wish{}).text == "1 x 5");
        CHECK(taken(inbox) == "view 1 1;1 x 6;1 y 5;2 x 5;");
    }

    TEST_CASE("a viewer may have few kinds of questions wait, and others as many") {
        Inbox inbox;
        for (std::size_t i = 0; i < max_asks_of_a_viewer; ++i) {
            CHECK(ask(inbox, 1, std::to_string(i), "").added == Inbox::Added::waits);
        }
        CHECK(ask(inbox, 1, "one more", "").added == Inbox::Added::full);
        CHECK(ask(inbox, 1, "0", "").added == Inbox::Added::waits);
        CHECK(ask(inbox, 2, "0", "").added == Inbox::Added::waits);
        CHECK(inbox.size() == max_asks_of_a_viewer + 1);
    }

    TEST_CASE("what waits changes the picture unless it only asks") {
        Inbox inbox;
        ask(inbox, 1, "slice x", "{}");
        add(inbox, "stats");
        add(inbox, "pick 1 2");
        CHECK(!inbox.changes_picture());
        for (const char* line : {"pick 1 2 set=bone", "view 1 1", "remove bone", "undo"}) {
            Inbox other;
            add(other, line);
            CHECK(other.changes_picture());
        }
    }

    TEST_CASE("there is an end to what waits, but a newer setting always has a place") {
        Inbox inbox;
        add(inbox, "view 0 0");
        for (std::size_t i = 1; i < max_waiting; ++i) {
            add(inbox, "surface s" + std::to_string(i) + " iso=1");
        }
        CHECK(add(inbox, "snapshot a.png").added == Inbox::Added::full);
        CHECK(add(inbox, "view 1 1").added == Inbox::Added::waits);
        CHECK(inbox.size() == max_waiting);
    }

    TEST_CASE("what is no command is refused, with the nearest name") {
        Inbox inbox;
        CHECK(error_of([&] { add(inbox, "surfice bone"); }).find("surface") != std::string::npos);
        CHECK(inbox.empty());
    }
}

TEST_SUITE("host/serve/pace") {
    TEST_CASE("late frames become smaller at once, down to a half") {
        Pace pace;
        CHECK(pace.scale() == 1);
        pace.drawn(41);
        CHECK(pace.scale() == 0.75);
        pace.drawn(100);
        pace.drawn(100);
        CHECK(pace.scale() == 0.5);
    }

    TEST_CASE("frames grow again only after several that leave room for it") {
        Pace pace;
        pace.drawn(100);
        for (int i = 0; i < 100; ++i) {
            pace.drawn(20);  // At the full size 36 ms: in time, but with no room.
        }
        CHECK(pace.scale() == 0.75);
        for (int i = 0; i < 7; ++i) {
            pace.drawn(10);
        }
        CHECK(pace.scale() == 0.75);
        pace.drawn(10);
        CHECK(pace.scale() == 1);
    }

    TEST_CASE("a frame with a kept part makes the next ones smaller, but never larger") {
        Pace pace;
        pace.drawn(41, false);
        CHECK(pace.scale() == 0.75);
        for (int i = 0; i < 100; ++i) {
            pace.drawn(1, false);
        }
        CHECK(pace.scale() == 0.75);
    }
}

TEST_SUITE("host/serve/viewer_message") {
    TEST_CASE("each message of the protocol is read") {
        const ViewerMessage line = read_viewer_message(R"({"id":7,"do":"view 1 2"})");
        CHECK(line.id == 7);
        CHECK(line.line == "view 1 2");
        CHECK(read_viewer_message(R"({"id":8,"ask":"slice","axis":"x"})").ask == "slice");
        CHECK(read_viewer_message(R"({"cancel":true})").cancels);
        CHECK(read_viewer_message(R"({"panel":false})").panel == false);
    }

    TEST_CASE("a question says along which axis it is") {
        CHECK(read_viewer_message(R"({"id":8,"ask":"slice","axis":"x"})").axis == "x");
        CHECK(!read_viewer_message(R"({"id":8,"ask":"scrub"})").axis);
        CHECK(read_viewer_message(R"({"id":8,"ask":"slice","axis":"x","ahead":true})").is_ahead);
        CHECK(!read_viewer_message(R"({"id":8,"ask":"slice","axis":"x"})").is_ahead);
        CHECK(error_of([] {
                  read_viewer_message(R"({"id":8,"ask":"slice","axis":2})");
              }).find("\"axis\" is 2") != std::string::npos);
    }

    TEST_CASE("lists and objects in each other are read to a depth, and no deeper") {
        const auto nested = [](std::size_t lists) {
            return R"({"id":1,"do":)" + std::string(lists, '[') + std::string(lists, ']') + "}";
        };
        CHECK(error_of([&] { read_viewer_message(nested(15)); }).find("\"do\" is an array") !=
              std::string::npos);
        CHECK(error_of([&] { read_viewer_message(nested(16)); }).find("17 deep; 16 may be") !=
              std::string::npos);
        CHECK(error_of([&] { read_viewer_message(nested(32'000)); }).find("32001 deep") !=
              std::string::npos);
        CHECK(error_of([] { read_viewer_message(std::string(65'536, '[')); }).find("65536 deep") !=
              std::string::npos);
    }

    TEST_CASE("what is no message is refused with a sentence that quotes it") {
        CHECK(error_of([] { read_viewer_message("[1"); }).find("'[1'") != std::string::npos);
        CHECK(error_of([] { read_viewer_message(R"({"id":1,"do":5})"); }).find("\"do\" is 5") !=
              std::string::npos);
        CHECK(error_of([] { read_viewer_message(R"({"id":1})"); }).find("0 of") !=
              std::string::npos);
        CHECK(error_of([] { read_viewer_message(R"({"do":"a","cancel":true})"); }).find("2 of") !=
              std::string::npos);
        CHECK(error_of([] {
                  read_viewer_message(R"({"id":4294967296,"do":"a"})");
              }).find("4294967296 is above 4294967295") != std::string::npos);
        CHECK(error_of([] { read_viewer_message(R"({"ask":"slice"})"); }).find("no id") !=
              std::string::npos);
    }
}
