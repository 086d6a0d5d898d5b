// Tests the events that wait for the session.
#include <doctest/doctest.h>

#include <string>

#include "host/serve/server/server_mail.hpp"

using namespace pxpl5::host::serve;

namespace {

/// "joined 1, said 1, left 1".
std::string words(const std::vector<Event>& events) {
    std::string text;
    for (const Event& event : events) {
        text += text.empty() ? "" : ", ";
        if (const auto* joined = std::get_if<Joined>(&event)) {
            text += "joined " + std::to_string(joined->viewer);
        } else if (const auto* left = std::get_if<Left>(&event)) {
            text += "left " + std::to_string(left->viewer);
        } else if (const auto* said = std::get_if<Said>(&event)) {
            text += "said " + std::to_string(said->viewer);
        }
    }
    return text;
}

}  // namespace

TEST_CASE("viewers that come and go while the session works do not pile up") {
    Mail mail;
    for (std::uint32_t viewer = 1; viewer <= 1000; viewer += 2) {
        CHECK(mail.push(Joined{viewer, Role::watcher}));
        CHECK(mail.push(Joined{viewer + 1, Role::driver}));
        CHECK(mail.push(Left{viewer}));
        CHECK(mail.push(Left{viewer + 1}));
    }
    CHECK(mail.push(Joined{1001, Role::driver}));
    CHECK(words(mail.take()) == "joined 1001");
}

TEST_CASE("what a viewer said is heard after it left, and a known viewer leaves") {
    Mail mail;
    CHECK(mail.push(Joined{1, Role::driver}));
    CHECK(mail.push(Said{1, Role::driver, "u"}));
    CHECK(mail.push(Left{1}));
    CHECK(mail.push(Joined{2, Role::driver}));
    CHECK(words(mail.take()) == "joined 1, said 1, left 1, joined 2");
    CHECK(mail.push(Left{2}));
    CHECK(words(mail.take()) == "left 2");
}

TEST_CASE("a resting picture keeps the layers of its state, whichever comes first") {
    Mail mail;
    mail.wake_server = [] {};
    const auto show = [&](std::uint32_t revision, bool rests, int layers) {
        Shown frame;
        frame.revision = revision;
        frame.rests = rests;
        frame.layers = layers;
        mail.show(frame);
        return mail.newest();
    };
    auto newest = show(1, true, 1);
    CHECK(newest->layers == nullptr);
    newest = show(1, false, 2);
    CHECK(newest->sequence == 1);
    CHECK(newest->shown.rests);
    REQUIRE(newest->layers != nullptr);
    CHECK(newest->layers->layers == 2);
    newest = show(1, true, 1);  // A refinement.
    CHECK(newest->sequence == 2);
    CHECK(newest->layers != nullptr);
    newest = show(2, false, 2);
    CHECK(newest->sequence == 3);
    CHECK(newest->shown.layers == 2);
    CHECK(newest->layers == nullptr);
    newest = show(2, true, 1);
    CHECK(newest->sequence == 4);
    REQUIRE(newest->layers != nullptr);
    CHECK(newest->layers->revision == 2);
    CHECK(show(3, true, 1)->layers == nullptr);
}
