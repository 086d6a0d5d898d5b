#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "host/base/reply.hpp"

using namespace pxpl5::host;

TEST_SUITE("host/reply") {
    TEST_CASE("a reply is one line of JSON with every kind of field") {
        const Reply reply{"text",
                          {{"flag", true},
                           {"count", std::int64_t{1} << 40},
                           {"mm", 0.5},
                           {"name", std::string("a \"b\"\n")},
                           {"dims", std::vector<double>{1, 2, 3}},
                           {"inner", Fields{{"x", std::int64_t{7}}}},
                           {"list", std::vector<Fields>{{{"y", std::int64_t{8}}}}}}};
        const std::string line = json_line({"surface a", "surface", 1.5}, reply);
        CHECK(line.find('\n') == std::string::npos);
        const auto json = nlohmann::json::parse(line);
        CHECK(json["command"] == "surface a");
        CHECK(json["name"] == "surface");
        CHECK(json["schema"] == 1);
        CHECK(json["warnings"].empty());
        CHECK(json["ok"] == true);
        CHECK(json["ms"] == 1.5);
        CHECK(json["result"]["flag"] == true);
        CHECK(json["result"]["count"] == std::int64_t{1} << 40);
        CHECK(json["result"]["name"] == "a \"b\"\n");
        CHECK(json["result"]["dims"][2] == 3);
        CHECK(json["result"]["inner"]["x"] == 7);
        CHECK(json["result"]["list"][0]["y"] == 8);
    }

    TEST_CASE("an error is one line of JSON, even with bytes that are not UTF-8") {
        const auto json =
            nlohmann::json::parse(json_error_line({"load \xff", "load", 2}, "no file", 65));
        CHECK(json["ok"] == false);
        CHECK(json["error"] == "no file");
        CHECK(json["exit_code"] == 65);
    }

    TEST_CASE("a warning is in the text and in JSON, and whole numbers stay whole") {
        Reply reply{"wrote a.png", {{"dims", std::vector<std::int64_t>{3, 4}}}};
        add_warning(reply, "nothing is visible in it", "; ");
        CHECK(reply.text == "wrote a.png; nothing is visible in it");
        const std::string line = json_line({"snapshot a.png", "snapshot", 1}, reply);
        CHECK(line.find("\"dims\":[3,4]") != std::string::npos);
        CHECK(line.find("\"warnings\":[\"nothing is visible in it\"]") != std::string::npos);
        const auto failed = nlohmann::json::parse(
            json_error_line({"snapshot a.png", "snapshot", 1}, "--strict", 3, &reply));
        CHECK(failed["ok"] == false);
        CHECK(failed["result"]["dims"][0] == 3);
        CHECK(failed["warnings"].size() == 1);
    }

    TEST_CASE("a line of CSV has a cell for every field") {
        const Fields fields{{"name", std::string("a \"b\", c")},
                            {"ms", 0.1},
                            {"count", std::int64_t{-3}},
                            {"held_back", true},
                            {"wall_ms", nullptr},
                            {"limit", std::string()}};
        CHECK(csv_heading(fields) == "name,ms,count,held_back,wall_ms,limit\n");
        CHECK(csv_line(fields) == "\"a \"\"b\"\", c\",0.1,-3,true,,\"\"\n");
        CHECK(csv_line({{"wall_ms", nullptr}, {"ms", 1.0}}) == ",1\n");
    }
}
