// A new row of the command table is all that a new command needs.
#include <doctest/doctest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/base/error.hpp"
#include "host/commands/command_options.hpp"
#include "host/commands/script.hpp"
#include "tests/system/simulated_machine.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

Reply run_haze(Session& session, const Arguments& arguments) {
    session.scene.material.ambient = arguments.number("depth", 0.25);
    return {"haze " + arguments.words[0], {{"depth", session.scene.material.ambient}}};
}

/// The table with one more row.
std::vector<Command> planted_table() {
    std::vector<Command> table(command_table().begin(), command_table().end());
    table.push_back({{.name = "haze",
                      .help = "Sets the haze.",
                      .words = {{"NAME", "NAME", "name of the haze"}},
                      .required = 1,
                      .options = {number_value("depth", "D", 0, 1, "depth of the haze")},
                      .kind = CommandKind::setting,
                      .subject_words = 1,
                      .stage = RenderStage::look},
                     run_haze});
    return table;
}

Topology small_machine() {
    Topology topology;
    topology.gp.count = topology.renderer.count = topology.frame_buffer.count = 1;
    topology.gp_memory_mib = 64;
    return topology;
}

}  // namespace

TEST_CASE("a planted descriptor has prompt, history, help, a render option, JSON and the page") {
    const std::vector<Command> table = planted_table();
    test::SimulatedMachine machine(small_machine());
    Session session(machine);
    // Prompt and scripts.
    CHECK(run_script(session, lines_of_text("haze fog depth=0.5"), {.table = table}) == 0);
    CHECK(session.scene.material.ambient == 0.5);
    CHECK(session.history.script().find("haze fog depth=0.5") != std::string::npos);
    CHECK(run_script(session, lines_of_text("haze fog depth=2"), {.table = table}) == 64);
    CHECK(run_script(session, lines_of_text("haze fog"), {}) == 64);  // Only this table has it.
    // Help.
    const Reply help = run_command(session, parse_line("help haze"), nullptr, table);
    CHECK(help.text.find("depth=D          depth of the haze (0 to 1)") != std::string::npos);
    // JSON, and with it the page's table.
    const auto json = nlohmann::json::parse(json_text({{"commands", table_fields(table)}}));
    CHECK(json["commands"].back()["name"] == "haze");
    CHECK(json["commands"].back()["kind"] == "setting");
    CHECK(json["commands"].back()["subject_words"] == 1);
    CHECK(json["commands"].back()["options"][0]["maximum"] == 1);
    CHECK(subject_of(parse_line("haze fog depth=1"), table) ==
          subject_of(parse_line("haze fog depth=0"), table));
    // The options of `render`.
    CLI::App app;
    const CommandOptions options(app, {RenderStage::look}, table);
    app.parse(std::vector<std::string>{"0.75", "--depth", "fog", "--haze"});
    REQUIRE(options.commands().size() == 1);
    CHECK(to_line(options.commands()[0]) == "haze fog depth=0.75");
}
