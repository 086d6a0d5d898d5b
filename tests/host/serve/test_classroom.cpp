#include <doctest/doctest.h>

#include <string>
#include <string_view>
#include <vector>

#include "host/serve/classroom/classroom.hpp"
#include "host/serve/texts/class_texts.hpp"

namespace pxpl5::host::serve {

namespace {

/// A class, and what its browsers and sessions do.
struct Class {
    int wakes = 0;
    Classroom room;

    explicit Class(int places) : room(places, [this] { ++wakes; }) {}

    /// Greets a browser with this cookie.
    PageAnswer comes(const std::string& cookie) {
        return room.answer_known([&](const std::string& secret) { return secret == cookie; });
    }
    /// The cookie of a browser that comes for the first time, with the token.
    std::string joins() { return room.answer_new().secret; }
    /// Starts the wanted sessions, and returns their number.
    int starts() { return static_cast<int>(room.take_wanted().size()); }
};

}  // namespace

TEST_CASE("a browser gets one session, which it finds again") {
    Class lab(3);
    const std::string ann = lab.joins(), bob = lab.joins();
    CHECK(ann != bob);
    CHECK(ann.size() == 32);
    CHECK(lab.room.taken() == 0);  // Browsers without cookies take no session.
    CHECK(lab.comes(ann).again_s == 1);
    CHECK(lab.comes(ann).heading.english == "Your session starts");
    CHECK(lab.wakes == 1);
    CHECK(lab.starts() == 1);
    CHECK(lab.starts() == 0);
    CHECK(lab.comes(bob).status == 200);
    CHECK(lab.starts() == 1);
    CHECK(lab.room.taken() == 2);
    CHECK(!lab.room.has_port(0));
    lab.room.ready(1, "http://127.0.0.1:4711/?token=aa");
    lab.room.ready(2, "https://[::1]:4712/?token=bb");
    CHECK(lab.comes(ann).port == 4711);
    CHECK(lab.comes(ann).token == "aa");
    CHECK(lab.comes(bob).port == 4712);
    CHECK(lab.comes(bob).token == "bb");
    CHECK(lab.room.has_port(4711));
    CHECK(!lab.room.has_port(4713));
    CHECK(!lab.room.has_port(0));
    CHECK(lab.comes("stranger").status == 0);
    CHECK(lab.comes("").status == 0);
}

TEST_CASE("more browsers than sessions wait until one has ended") {
    Class lab(1);
    const std::string ann = lab.joins(), bob = lab.joins();
    CHECK(lab.comes(ann).status == 200);
    const PageAnswer full = lab.comes(bob);
    CHECK(full.status == 503);
    CHECK(full.heading.english == "The only session is taken");
    CHECK(full.again_s > 0);
    const auto first = lab.room.take_wanted();
    REQUIRE(first.size() == 1);
    CHECK(first[0].place == 1);
    lab.room.ended(first[0].number, "It has no memory.");
    CHECK(lab.comes(bob).heading.english == "Your session starts");
    const auto second = lab.room.take_wanted();
    REQUIRE(second.size() == 1);
    CHECK(second[0].number == 2);
    CHECK(second[0].place == 1);
    // The other browser reads the reason once, and waits after that.
    CHECK(lab.comes(ann).heading.english == "Your session has ended");
    CHECK(lab.comes(ann).status == 503);
    lab.room.ended(2, "");
    CHECK(lab.comes(ann).heading.english == "Your session starts");
}

TEST_CASE("a browser gets the reason of the end of its session once") {
    Class lab(2);
    const std::string ann = lab.joins();
    lab.comes(ann);
    lab.starts();
    lab.room.ended(7, "Another session.");
    CHECK(lab.room.taken() == 1);
    lab.room.ended(1, "It has no memory.");
    CHECK(lab.room.taken() == 0);
    const PageAnswer end = lab.comes(ann);
    CHECK(end.why == "It has no memory.");
    CHECK(end.sentence.english == "Reload this page to begin a new one.");
    CHECK(lab.comes(ann).heading.english == "Your session starts");
    CHECK(lab.starts() == 1);
}

TEST_CASE("a place that has failed is not the next one, because its port may be taken") {
    Class lab(3);
    std::vector<int> places;
    for (int i = 0; i < 4; ++i) {
        lab.comes(lab.joins());
        const auto wanted = lab.room.take_wanted();
        REQUIRE(wanted.size() == 1);
        places.push_back(wanted[0].place);
        lab.room.ended(wanted[0].number, "Its port is taken.");
    }
    CHECK(places == std::vector<int>{1, 2, 3, 1});
    lab.comes(lab.joins());
    lab.comes(lab.joins());
    CHECK(lab.room.take_wanted()[1].place == 3);
}

TEST_CASE("the first browser gets the session that was started ahead") {
    Class lab(2);
    lab.room.want_one();
    CHECK(lab.starts() == 1);
    CHECK(lab.room.taken() == 0);
    lab.room.ready(1, "http://127.0.0.1:4711/?token=aa");
    CHECK(lab.comes("").status == 0);  // A session without a browser has no secret yet.
    const std::string ann = lab.joins(), bob = lab.joins();
    CHECK(lab.comes(ann).again_s == 1);
    CHECK(lab.comes(ann).port == 4711);
    CHECK(lab.starts() == 0);
    CHECK(lab.comes(bob).port == 0);
    CHECK(lab.starts() == 1);
    CHECK(lab.room.taken() == 2);
    lab.room.ended(2, "x");
    lab.room.ended(1, "y");
    CHECK(lab.comes(ann).why == "y");
}

TEST_CASE("an address without a port is no address") {
    Class lab(1);
    const std::string ann = lab.joins();
    lab.comes(ann);
    lab.starts();
    for (const char* url : {"", "http://127.0.0.1/?token=aa", "http://127.0.0.1:x/?token=aa",
                            "http://127.0.0.1:4711/", "http://127.0.0.1:99999/?token=aa"}) {
        lab.room.ready(1, url);
        CHECK_MESSAGE(lab.comes(ann).port == 0, url);
    }
}

TEST_CASE("each language has all texts of the page, and no other") {
    for (const std::string_view english : class_text::all) {
        CHECK_MESSAGE(has_text(english, "de"), english);
        const bool has_place = english.find("{0}") != std::string_view::npos;
        const std::string german = text_in({english}, "de");
        CHECK_MESSAGE((german.find("{0}") != std::string::npos) == has_place, english);
    }
    CHECK(count_of_texts("de") == class_text::all.size());
    CHECK(!has_text("Your session", "de"));
    CHECK(has_text("Your session", "en"));
    CHECK(count_of_texts("fr") == 0);
    CHECK(text_in({class_text::starts}, "fr") == class_text::starts);
}

TEST_CASE("the page follows the address, then the browser") {
    CHECK(language_of("", "") == "en");
    CHECK(language_of("de", "en") == "de");
    CHECK(language_of("DE-at", "") == "de");
    CHECK(language_of("marked", "de") == "de");
    CHECK(language_of("", "de-AT,de;q=0.9,en;q=0.8") == "de");
    CHECK(language_of("", "fr-CH, fr;q=0.9, en;q=0.3, de;q=0.7, *;q=0.5") == "de");
    CHECK(language_of("", "en-US,en;q=0.5,de;q=0.3") == "en");
    CHECK(language_of("", "de;q=0, en;q=0.1") == "en");
    CHECK(language_of("", "fr, ,;,de;q=x,q=1") == "en");
}

TEST_CASE("the page is in the language of its reader, and names what is not") {
    Class lab(2);
    for (int n = 0; n < 2; ++n) {
        lab.comes(lab.joins());
    }
    const std::string full = page_text(lab.comes(lab.joins()), "de");
    CHECK(full.find("<html lang=\"de\">") != std::string::npos);
    CHECK(full.find("<h1>Alle 2 Sitzungen sind vergeben</h1>") != std::string::npos);
    CHECK(full.find("<p>Diese Seite fragt alle 15 Sekunden erneut") != std::string::npos);

    PageAnswer end{200, {class_text::has_ended}, {class_text::begin_anew}};
    end.why = "a<b.";
    CHECK(page_text(end, "de").find("<p><span lang=\"en\">a&lt;b.</span> Laden Sie") !=
          std::string::npos);
    CHECK(page_text(end, "en").find("<p>a&lt;b. Reload this page") != std::string::npos);
    end.why = class_text::asked_to_end;
    CHECK(page_text(end, "de").find("<p>Die Sitzung wurde beendet, ") != std::string::npos);
}

TEST_CASE("the port of a session ends the path") {
    CHECK(last_port_in("/4711/") == 4711);
    CHECK(last_port_in("/rnode/n1/4711/") == 4711);
    for (const char* path : {"", "/", "//", "/4711", "4711", "/a/", "/47a/", "/-1/", "/65536/",
                             "/0/", "/99999999999/", "/4711/main.js"}) {
        CHECK_MESSAGE(last_port_in(path) == 0, path);
    }
}

TEST_CASE("a page shows texts as texts") {
    const std::string page = page_text({200, {"A & <b>"}, {"</p><script>"}, 5}, "en");
    CHECK(page.find("<h1>A &amp; &lt;b></h1><p>&lt;/p>&lt;script></p>") != std::string::npos);
    CHECK(page.find("content=\"5\"") != std::string::npos);
    CHECK(page_text({200, {"A"}, {"B"}}, "en").find("refresh") == std::string::npos);
}

}  // namespace pxpl5::host::serve
