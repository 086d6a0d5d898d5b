#include <doctest/doctest.h>

#include "host/base/answer.hpp"

using namespace pxpl5::host;

namespace {

Table nodes() {
    Table table{"nodes", {{"name", "node"}, {"bytes", "bytes"}, {"cut", ""}, {"", "state"}}};
    table.rows.push_back({"gp-0", grouped_cell(12345), nullptr, "complete"});
    table.rows.push_back({"host", grouped_cell(7), "at 3", "cut"});
    return table;
}

}  // namespace

TEST_CASE("one answer is text, JSON and CSV: columns choose where they are shown") {
    Answer answer;
    answer.line("2 nodes").data("count", 2).table(nodes());
    CHECK(rendered(answer, Format::text) ==
          "2 nodes\nnode   bytes     state\ngp-0  12,345  complete\nhost       7       cut\n");
    CHECK(rendered(answer, Format::json) ==
          R"({"count":2,"nodes":[{"name":"gp-0","bytes":12345,"cut":null},)"
          R"({"name":"host","bytes":7,"cut":"at 3"}]})"
          "\n");
    CHECK(rendered(answer, Format::csv) ==
          "name,bytes,cut\n\"gp-0\",12345,\n\"host\",7,\"at 3\"\n");
}

TEST_CASE("CSV shows a table of its own if the answer has one") {
    Answer answer;
    answer.table(nodes()).csv_table({"", {{"a", ""}}, {{1.5}}});
    CHECK(answer.csv() == "a\n1.5\n");
    CHECK(answer.text().find("1.5") == std::string::npos);
    CHECK(Answer().csv().empty());
}

TEST_CASE("answers inside an answer are objects in JSON and follow in the text") {
    Answer inner, outer;
    inner.line("inside").data("x", 1);
    outer.line("outside").object("part", inner).object("", inner).list("parts", {inner, inner});
    CHECK(outer.text() == "outside\ninside\ninside\ninside\ninside\n");
    CHECK(json_text(outer.fields()) == R"({"part":{"x":1},"parts":[{"x":1},{"x":1}]})");
    CHECK(outer.reply().text.ends_with("inside"));
}

TEST_CASE("a list without elements is in JSON, a value that is missing is not") {
    Answer answer;
    answer.sentences("missing", "text", "Not counted: ", {})
        .data_if("gap", std::optional<int>())
        .data_if("there", std::optional(3))
        .data_if("reason", std::string());
    CHECK(json_text(answer.fields()) == R"({"missing":[],"there":3})");
    CHECK(answer.text().empty());
}

TEST_CASE("numbers are grouped and have plurals") {
    CHECK(grouped(0) == "0");
    CHECK(grouped(999) == "999");
    CHECK(grouped(1234567) == "1,234,567");
    CHECK(counted(1, "word") == "1 word");
    CHECK(counted(4182, "word") == "4,182 words");
    CHECK(hex_cell(255).text == "00000000000000ff");
    CHECK(fixed_cell(0.125, 2).text == "0.12");
}
