// What waits to be done, how large moving pictures are, and what viewers' messages mean.
#include <doctest/doctest.h>

#include <functional>

#include "host/error.hpp"
#include "host/serve/inbox.hpp"
#include "host/serve/pace.hpp"
#include "host/serve/viewer_message.hpp"

using namespace pxpl5::host;
using namespace pxpl5::host::serve;

namespace {

Inbox::Outcome add(Inbox& inbox, const std::string& line, std::uint32_t id = 0) {
    return inbox.add({1, id, false, line, parse_line(line)});
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
        CHECK(taken(inbox) == "surface bone iso=2;view 10 20;");
    }

    TEST_CASE("an action or a question sees what was set before it, and not what was set after") {
        for (const char* between : {"snapshot a.png", "pick 1 2 set=bone", "clip off", "undo"}) {
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
        inbox.add({1, 7, true, "{}", {}});
        CHECK(add(inbox, "surface bone iso=2").superseded);
        CHECK(inbox.size() == 2);
        inbox.forget_asks(1);
        CHECK(taken(inbox) == "surface bone iso=2;");
    }

    TEST_CASE("there is an end to what waits, but a newer setting always has a place") {
        Inbox inbox;
        add(inbox, "view 0 0");
        for (std::size_t i = 1; i < max_waiting; ++i) {
            inbox.add({1, 7, true, "{}", {}});
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
