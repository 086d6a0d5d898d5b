#include <doctest/doctest.h>
#include <poll.h>

#include "host/serve/server/server_mail.hpp"
#include "host/serve/server/server_viewer.hpp"

namespace pxpl5::host::serve {
namespace {

Outgoing text(std::size_t bytes) {
    return {0, false, std::make_shared<const std::string>(bytes, 't')};
}

NewestFrame frame(std::uint64_t sequence) {
    return {sequence, {}};
}

bool is_readable(int fd) {
    pollfd wait{fd, POLLIN, 0};
    return poll(&wait, 1, 0) == 1;
}

}  // namespace

TEST_CASE("parts make up a message, 64 KiB at most") {
    Viewer viewer(1, Role::driver);
    CHECK_FALSE(viewer.hear("{\"a\"", false, 0));
    CHECK(viewer.hear(":1}", true, 0) == "{\"a\":1}");
    CHECK(viewer.hear(std::string(max_text_bytes, 'x'), true, 0)->size() == max_text_bytes);
    CHECK(viewer.closing.code == 0);
    CHECK_FALSE(viewer.hear(std::string(max_text_bytes, 'x'), false, 0));
    CHECK(viewer.closing.code == 0);
    CHECK_FALSE(viewer.hear("x", true, 0));
    CHECK(viewer.closing.code == 1009);
}

TEST_CASE("a viewer may say 400 messages a second for ever, 800 at once and not one more") {
    Viewer steady(1, Role::driver);
    for (int i = 0; i < 10'000; ++i) {
        CHECK(steady.hear("x", true, i * 2.5));
    }
    Viewer flood(2, Role::driver);
    for (int i = 0; i < 800; ++i) {
        REQUIRE(flood.hear("x", true, 1e6));
    }
    CHECK(flood.closing.code == 0);
    CHECK_FALSE(flood.hear("x", true, 1e6));
    CHECK(flood.closing.code == 1008);
}

TEST_CASE("more than 8 MiB in wait for a viewer close it, one large message does not") {
    Viewer viewer(1, Role::driver);
    viewer.line_up(text(max_waiting_bytes * 2));
    CHECK(viewer.closing.code == 0);
    CHECK(viewer.next_message()->bytes->size() == max_waiting_bytes * 2);
    viewer.line_up(text(max_waiting_bytes / 2));
    viewer.line_up(text(max_waiting_bytes / 2));
    CHECK(viewer.closing.code == 0);
    viewer.line_up(text(1));
    CHECK(viewer.closing.code == 1013);
    CHECK_FALSE(viewer.has_messages());
}

TEST_CASE("a viewer with depths gets the layers of the resting picture once") {
    Viewer viewer(1, Role::driver);
    viewer.line_up(text(1));
    viewer.next_message();
    auto layers = std::make_shared<Shown>();
    layers->layers = 2;
    layers->revision = 7;
    NewestFrame newest{5, {}, layers};
    CHECK(viewer.next_of(newest) == &newest.shown);
    viewer.count_frame(newest);
    CHECK_FALSE(viewer.takes(newest));
    viewer.wants_depths = true;
    CHECK(viewer.takes(newest));
    CHECK(viewer.next_of(newest) == layers.get());
    viewer.count_frame(newest);
    CHECK_FALSE(viewer.takes(newest));
    viewer.link.shown(2, 0);
    const NewestFrame moving{6, *layers, nullptr};  // A viewer who had it does not get it again.
    viewer.count_frame(moving);
    newest.sequence = 7;
    viewer.count_frame(newest);
    CHECK(viewer.next_of(newest) == nullptr);
    layers->revision = 8;
    CHECK(viewer.next_of(newest) == layers.get());
}

TEST_CASE("a viewer takes each frame once, and no third while two are unacknowledged") {
    Viewer viewer(1, Role::driver);
    CHECK_FALSE(viewer.takes(frame(5)));
    viewer.line_up(text(1));
    CHECK_FALSE(viewer.takes(frame(5)));  // The greeting goes first.
    viewer.next_message();
    CHECK_FALSE(viewer.takes(frame(0)));
    CHECK(viewer.wants_newer(frame(0)));
    CHECK(viewer.takes(frame(5)));
    CHECK_FALSE(viewer.wants_newer(frame(5)));
    CHECK(viewer.count_frame(frame(5)) == 1);
    viewer.link.sent(1, 100, 0);
    CHECK_FALSE(viewer.takes(frame(5)));
    CHECK(viewer.wants_newer(frame(5)));
    CHECK(viewer.count_frame(frame(9)) == 2);
    viewer.link.sent(2, 100, 0);
    CHECK_FALSE(viewer.wants_newer(frame(9)));
    CHECK_FALSE(viewer.takes(frame(10)));
    viewer.link.shown(1, 1);
    CHECK(viewer.takes(frame(10)));
}

TEST_CASE("a viewer that asks for depths late gets the newest frame again, with its depths") {
    Viewer viewer(1, Role::driver);
    viewer.line_up({.viewer = 1, .binary = false, .bytes = std::make_shared<std::string>("hi")});
    viewer.next_message();
    NewestFrame newest = frame(5);
    viewer.count_frame(newest);
    viewer.want_depths(true, newest);
    CHECK_FALSE(viewer.takes(newest));  // The frame has none.
    viewer.want_depths(false, newest);
    newest.shown.depths = std::vector<std::uint32_t>(1);
    viewer.want_depths(true, newest);
    CHECK(viewer.takes(newest));
    viewer.count_frame(newest);
    viewer.want_depths(true, newest);  // It had asked before.
    CHECK_FALSE(viewer.takes(newest));
}

TEST_CASE("only the plain message that a frame was shown is the server's") {
    CHECK(shown_frame("{\"shown\":123}")->number == 123U);
    CHECK(shown_frame("{\"shown\":123}")->since_arrival_ms == 0);
    CHECK(shown_frame("{\"shown\":123,\"after_ms\":7.5}")->since_arrival_ms == 7.5);
    CHECK(shown_frame(" { \"shown\" : 4294967295 } ")->number == 4294967295U);
    for (const char* other :
         {"", "{}", "{\"shown\":-1}", "{\"shown\":4294967296}", "[\"shown\"]", "{\"shown\":\"1\"}",
          "{\"shown\":1.5}", "{\"shown\":1", "{\"shown\":1,\"id\":2}",
          "{\"shown\":1,\"after_ms\":-1}", "{\"shown\":1,\"after_ms\":\"1\"}",
          "{\"shown\":1,\"after_ms\":1,\"id\":2}", "{\"after_ms\":1}",
          "{\"do\":\"\\\"shown\\\"\"}"}) {
        CAPTURE(other);
        CHECK_FALSE(shown_frame(other));
    }
}

TEST_CASE("only the plain messages about depths and video are the server's") {
    CHECK(wanted_depths("{\"depths\":true}") == true);
    CHECK(wanted_depths(" { \"depths\" : false } ") == false);
    CHECK(wanted_video("{\"video\":true}") == true);
    CHECK(wanted_video("{\"video\":false}") == false);
    for (const std::string key : {"depths", "video"}) {
        for (const std::string other :
             {"", "{}", "{\"KEY\":1}", "{\"KEY\":null}", "[\"KEY\"]", "{\"KEY\":true",
              "{\"KEY\":true,\"id\":2}", "{\"do\":\"\\\"KEY\\\"\"}"}) {
            std::string text = other;
            if (const auto at = text.find("KEY"); at != std::string::npos) {
                text.replace(at, 3, key);
            }
            CAPTURE(text);
            CHECK_FALSE(wanted_depths(text));
            CHECK_FALSE(wanted_video(text));
        }
    }
    CHECK_FALSE(wanted_video("{\"depths\":true}"));
}

TEST_CASE("events wake the session once, until it takes them all") {
    Mail mail;
    CHECK_FALSE(is_readable(mail.event_fd()));
    mail.push(Joined{1, Role::driver});
    mail.push(Said{1, Role::driver, "a"});
    CHECK(is_readable(mail.event_fd()));
    CHECK(mail.take().size() == 2);
    CHECK_FALSE(is_readable(mail.event_fd()));
    CHECK(mail.take().empty());
}

TEST_CASE("a session that lags refuses texts, never joins and leaves") {
    Mail mail;
    const std::string longest(max_text_bytes, 'x');
    std::size_t kept = 0;
    while (mail.push(Said{1, Role::driver, longest})) {
        ++kept;
    }
    CHECK(kept * max_text_bytes <= max_waiting_event_bytes);
    CHECK((kept + 2) * max_text_bytes > max_waiting_event_bytes);
    CHECK(mail.push(Left{1}));
    CHECK(mail.take().size() == kept + 1);
    CHECK(mail.push(Said{1, Role::driver, longest}));
}

TEST_CASE("a frame is wanted only by who has seen that a newer one is there") {
    Mail mail;
    int woken = 0;
    mail.wake_server = [&] { ++woken; };
    CHECK_FALSE(mail.advice().wants_depths);
    mail.advise({true, 0, false, 0, {0.75, true}});
    CHECK(mail.wants_frame());
    CHECK(is_readable(mail.event_fd()));
    CHECK(mail.advice().scale == 0.75);
    CHECK(mail.advice().wants_depths);
    mail.take();
    mail.show({});
    CHECK(woken == 1);
    CHECK_FALSE(mail.wants_frame());
    mail.advise({true, 0, false, 0, {}});
    CHECK_FALSE(mail.wants_frame());
    CHECK_FALSE(is_readable(mail.event_fd()));
    mail.advise({true, mail.newest()->sequence, false, 0, {}});
    CHECK(mail.wants_frame());
}

TEST_CASE("the headset gets pairs, other viewers frames for all, and neither misses one") {
    Mail mail;
    int woken = 0;
    mail.wake_server = [&] { ++woken; };
    Shown plain, pair, strange;
    pair.viewer = 2;
    pair.pose = 7;
    strange.viewer = 3;
    mail.show(plain);
    mail.show(pair);  // Dropped, because no viewer wears a headset.
    CHECK(mail.newest(2)->sequence == 1);
    mail.wear(2, 1000);
    CHECK(mail.wearer().viewer == 2);
    CHECK(mail.wearer().pair_pixels == 1000);
    CHECK(mail.newest(2)->sequence == 0);
    CHECK(mail.newest(1)->sequence == 1);

    Viewer wearer(2, Role::driver);
    wearer.line_up(text(1));
    wearer.next_message();
    wearer.count_frame(*mail.newest());  // From before.
    CHECK_FALSE(wearer.takes(*mail.newest(2)));
    CHECK(wearer.wants_newer(*mail.newest(2)));
    mail.take();
    mail.advise({false, 1, true, 0, {1, false, 0.5}});
    CHECK(mail.wants_pair());
    CHECK_FALSE(mail.wants_frame());
    CHECK(mail.advice().pair_scale == 0.5);
    CHECK(is_readable(mail.event_fd()));
    mail.show(pair);
    mail.show(strange);
    CHECK_FALSE(mail.wants_pair());
    CHECK(mail.newest(2)->shown.pose == 7);
    CHECK(mail.newest(3)->shown.pose == 0);
    CHECK(wearer.takes(*mail.newest(2)));
    mail.advise({false, 1, true, 0, {}});  // The server has not seen the pair yet.
    CHECK_FALSE(mail.wants_pair());
    CHECK(wearer.count_frame(*mail.newest(2)) == 2);
    CHECK_FALSE(wearer.takes(*mail.newest(2)));
    mail.show(plain);
    mail.show(pair);
    wearer.count_frame(*mail.newest(2));
    mail.wear(2, 2000);  // Another size: the pair stays.
    CHECK(mail.newest(2)->shown.pose == 7);
    mail.wear(0, 0);
    CHECK(wearer.takes(*mail.newest(2)));  // The frame for all, which it has missed.
    mail.wear(2, 1000);
    CHECK_FALSE(wearer.takes(*mail.newest(2)));
    CHECK(wearer.wants_newer(*mail.newest(2)));
}

}  // namespace pxpl5::host::serve
