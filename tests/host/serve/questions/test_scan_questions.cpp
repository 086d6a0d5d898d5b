// Tests questions about DICOM files: what is asked, and what the lines of pxpl5-io become.
#include <doctest/doctest.h>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "host/base/command_line.hpp"
#include "host/base/error.hpp"
#include "host/serve/director/scan_questions.hpp"

namespace pxpl5::host::serve {
namespace {

using Json = nlohmann::json;

const std::string list = R"({"series":[{"number":1},{"number":2}],"more":3})"
                         "\n";
const std::string picture = R"({"thumbnail":1,"width":2,"height":1,"pixels":"0aff"})"
                            "\n";

/// The messages that viewers have been sent.
class Sent {
  public:
    void add(std::string message) {
        const std::lock_guard lock(mutex_);
        messages_.push_back(std::move(message));
        changed_.notify_all();
    }
    /// The next message; empty after 60 s.
    std::string next() {
        std::unique_lock lock(mutex_);
        if (!changed_.wait_for(lock, std::chrono::minutes(1), [&] { return !messages_.empty(); })) {
            return "";
        }
        std::string message = std::move(messages_.front());
        messages_.pop_front();
        return message;
    }

  private:
    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<std::string> messages_;
};

/// Questions that a script of the shell answers in place of pxpl5-io: $1 and $2 are the question.
ScanQuestions::Parts answered_by(const std::string& script, Sent& sent) {
    const auto send = [&sent](std::uint32_t viewer, std::string message) {
        sent.add(std::to_string(viewer) + " " + std::move(message));
    };
    return {{"/bin/sh", "-c", script, "sh"}, [](const std::string&) {}, send, send};
}

const Json series_of_x = {{"ask", "series"}, {"path", "/x"}};

}  // namespace

TEST_CASE("an answer follows a question, with its id and the viewer's") {
    Sent sent;
    ScanQuestions questions(answered_by(
        R"([ "$1" != --series ] || echo '{"series":[{"uid":"'"$1 $2"'"}],"more":0}')", sent));
    CHECK(questions.ask(7, 258, series_of_x.dump(), {}));
    const std::string message = sent.next();
    CHECK(message.starts_with("7 "));
    CHECK_MESSAGE(message.find(R"({"uid":"--series /x"})") != std::string::npos, message);
    CHECK(message.find(std::string("\2\1\0\0", 4)) != std::string::npos);
    CHECK(questions.ask(8, 9, R"({"ask":"attributes"})", {"/y", "1.2"}));
    CHECK(sent.next() ==
          R"(8 {"re":9,"ok":false,"error":"/y: pxpl5-io has listed no attributes"})");
}

TEST_CASE("a process that fails or cannot start is an error of its question") {
    Sent sent;
    ScanQuestions fails(answered_by("echo \"$2 $3 is cut\" >&2; exit 65", sent));
    CHECK(fails.ask(7, 3, R"({"ask":"attributes"})", {"/y", "1.2"}));
    CHECK(sent.next() == R"(7 {"re":3,"ok":false,"error":"/y series=1.2 is cut"})");
    ScanQuestions::Parts parts = answered_by("", sent);
    parts.words = {"/nowhere/pxpl5-io"};
    ScanQuestions nowhere(std::move(parts));
    CHECK(nowhere.ask(7, 4, series_of_x.dump(), {}));
    CHECK(sent.next().starts_with(
        R"(7 {"re":4,"ok":false,"error":"/nowhere/pxpl5-io cannot start: No such file)"));
}

TEST_CASE("a newer question, and the end of the server, end a process") {
    Sent sent;
    {
        ScanQuestions questions(answered_by("exec tail -f /dev/null", sent));
        CHECK(questions.ask(7, 1, series_of_x.dump(), {}));
        CHECK(questions.ask(8, 2, series_of_x.dump(), {}));
        CHECK(sent.next().starts_with(R"(7 {"re":1,"ok":false,"error":"ask: a newer question)"));
    }
    CHECK(sent.next().starts_with(R"(8 {"re":2,"ok":false,"error":"ask: a newer question)"));
}

TEST_CASE("a thumbnail becomes pixels, and its row says where they are") {
    const std::string other = R"({"thumbnail":0,"width":1,"height":1,"pixels":"7f"})";
    const SeriesAnswer answer = read_series_lines(list + picture + other, "");
    CHECK(answer.pixels == "\x0a\xff\x7f");
    const Json json = Json::parse(answer.json);
    CHECK(json["more"] == 3);
    CHECK(json["note"] == "");
    CHECK(json["series"][1]["thumbnail"] == Json{{"first", 0}, {"width", 2}, {"height", 1}});
    CHECK(json["series"][0]["thumbnail"] == Json{{"first", 2}, {"width", 1}, {"height", 1}});
}

TEST_CASE("lines that are cut or lie leave the thumbnail out") {
    for (const char* line :
         {R"({"thumbnail":1,"width":2,"height":1,"pixels":"0aff)",
          R"({"thumbnail":1,"width":2,"height":1,"pixels":"0a"})",
          R"({"thumbnail":1,"width":2,"height":1,"pixels":"0affaa"})",
          R"({"thumbnail":1,"width":2,"height":1,"pixels":"0afg"})",
          R"({"thumbnail":1,"width":0,"height":1,"pixels":""})",
          R"({"thumbnail":1,"width":4294967296,"height":4294967296,"pixels":""})",
          R"({"thumbnail":2,"width":2,"height":1,"pixels":"0aff"})",
          R"({"thumbnail":-1,"width":2,"height":1,"pixels":"0aff"})",
          R"({"thumbnail":1,"width":2,"height":1,"pixels":3})", "[]", "7"}) {
        CAPTURE(line);
        const SeriesAnswer answer = read_series_lines(list + line + "\n", "it was killed");
        CHECK(answer.pixels.empty());
        const Json json = Json::parse(answer.json);
        CHECK(json["series"] == Json{{{"number", 1}}, {{"number", 2}}});
        CHECK(json["note"] == "it was killed");
    }
}

TEST_CASE("answers that are nested too deeply are no answers") {
    const auto nested = [](int depth) {
        return std::string(static_cast<std::size_t>(depth), '[') +
               std::string(static_cast<std::size_t>(depth), ']');
    };
    const auto row = [&](int depth) { return R"({"series":[{"a":)" + nested(depth) + "}]}\n"; };
    CHECK(Json::parse(read_series_lines(row(8), "").json)["series"].size() == 1);
    for (const int depth : {17, 250'000}) {
        CHECK_THROWS_WITH_AS(read_series_lines(row(depth), ""), "pxpl5-io has listed no series",
                             RequestError);
        const std::string line = R"({"thumbnail":1,"a":)" + nested(depth) + "}\n";
        CHECK(read_series_lines(list + line, "").pixels.empty());
    }
}

TEST_CASE("an answer without a list is an error that says why") {
    for (const std::string lines : {"", "{\"series\":[{\"numb", "{\"series\":3}\n", "[]\n"}) {
        CAPTURE(lines);
        CHECK_THROWS_WITH_AS(read_series_lines(lines, "a.dcm: is cut"), "a.dcm: is cut",
                             RequestError);
        CHECK_THROWS_WITH_AS(read_series_lines(lines, ""), "pxpl5-io has listed no series",
                             RequestError);
    }
}

TEST_CASE("a question asks for a path that may be read, and for nothing else") {
    std::string checked;
    ScanQuestions questions({{},
                             [&](const std::string& path) {
                                 checked = path;
                                 refuse_command("not allowed");
                             },
                             {},
                             {}});
    ScanQuestions::OpenScan open;
    const auto refusal = [&](const Json& message) -> std::string {
        try {
            return questions.ask(1, 2, message.dump(), open) ? "asked" : "";
        } catch (const RequestError& error) {
            return error.what();
        }
    };
    CHECK(refusal({{"ask", "slice"}}) == "");
    CHECK(refusal({{"ask", 3}}) == "");
    CHECK(refusal({{"ask", "attributes"}}).find("no file is open") != std::string::npos);
    open.source = "phantom:pelvis";
    CHECK(refusal({{"ask", "attributes"}}).find("no file is open") != std::string::npos);
    for (const Json& path :
         {Json(), Json(3), Json("x"), Json("--allow=/etc"), Json(std::string("/a\0b", 4))}) {
        CAPTURE(path.dump());
        CHECK(refusal({{"ask", "series"}, {"path", path}}).find("must be a path from /") !=
              std::string::npos);
    }
    CHECK(checked.empty());
    CHECK(refusal({{"ask", "series"}, {"path", "/x"}}) == "not allowed");
    CHECK(checked == "/x");
    open.source = "/y";
    CHECK(refusal({{"ask", "attributes"}}) == "not allowed");
    CHECK(checked == "/y");
}

}  // namespace pxpl5::host::serve
