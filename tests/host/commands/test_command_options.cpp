// The long options of `render` and the commands that they stand for.
#include <doctest/doctest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include "host/base/error.hpp"
#include "host/commands/command_options.hpp"

using namespace pxpl5::host;

namespace {

const std::string picture_file = (std::filesystem::temp_directory_path() / "p.png").string();

/// The command lines that `render` runs for these arguments.
std::vector<std::string> lines_of(std::vector<std::string> words, const char* volume,
                                  CommandTable table = command_table()) {
    using enum RenderStage;
    CLI::App app;
    const CommandOptions options(app, {look, load, scene, output}, table);
    std::ranges::reverse(words);
    app.parse(words);
    std::vector<std::string> lines;
    for (const Arguments& each :
         render_commands({volume, picture_file, {}, options.commands()}, table)) {
        lines.push_back(to_line(each));
    }
    return lines;
}

using Lines = std::vector<std::string>;

}  // namespace

TEST_CASE("old spellings of render mean what they meant") {
    CHECK(lines_of({"--iso", "300", "--view", "30 20 zoom=2", "--size", "64x64"}, "a.nrrd") ==
          Lines{"view 30 20 zoom=2", "size 64x64", "load a.nrrd", "surface surface iso=300",
                "snapshot " + picture_file});
    CHECK(lines_of({"--surface", "skin=-300,skin", "--surface", "bone=300"}, "a.nrrd") ==
          Lines{"load a.nrrd", "surface skin color=skin iso=-300", "surface bone iso=300",
                "view fit=yes", "snapshot " + picture_file});
    CHECK(lines_of({}, "phantom:pelvis") ==
          Lines{"load phantom:pelvis", "surface bone", "view fit=yes", "snapshot " + picture_file});
}

TEST_CASE("the view of render fits the surfaces unless the user chose its scale") {
    const auto views_of = [](const std::vector<std::string>& words, const char* volume) {
        Lines views = lines_of(words, volume);
        std::erase_if(views, [](const std::string& line) { return !line.starts_with("view"); });
        return views;
    };
    const char* volume = "phantom:pelvis";
    CHECK(views_of({"--view", "left"}, volume) == Lines{"view left", "view fit=yes"});
    CHECK(views_of({"--roll", "9"}, volume) == Lines{"view roll=9", "view fit=yes"});
    CHECK(views_of({"--zoom", "1"}, volume) == Lines{"view zoom=1"});
    CHECK(views_of({"--view", "left pan=1,2"}, volume) == Lines{"view left pan=1,2"});
    CHECK(views_of({"--view", "left fit=no"}, volume) == Lines{"view left"});
    CHECK(views_of({"--orbit", "9 o.gif"}, volume).empty());
    CHECK(views_of({}, "scene.phigs").empty());
    // A wish before the volume is loaded would fit nothing.
    CHECK(views_of({"--view", "left zoom=2 fit=yes"}, volume) ==
          Lines{"view left zoom=2", "view fit=yes"});
    CHECK(views_of({"--fit", "yes"}, volume) == Lines{"view fit=yes"});
}

TEST_CASE("an option of a command with words needs the command before it") {
    CHECK_THROWS_WITH_AS(lines_of({"--min_ml", "5"}, "phantom:pelvis"),
                         "--min_ml needs --components NAME before it", RequestError);
}

TEST_CASE("help has the form and the unit of each value") {
    CLI::App app;
    const CommandOptions options(app, {RenderStage::load, RenderStage::scene});
    const auto form_of = [&](const char* name) { return app.get_option(name)->get_type_name(); };
    CHECK(form_of("--smooth") == "MM");
    CHECK(form_of("--crop") == "A:B,C:D,E:F");
    CHECK(form_of("--clip") == "WORDS");
    CHECK(app.get_option("--components")->get_description().find(".;") == std::string::npos);
    CHECK(app.get_option("--min_ml")->get_description().ends_with(" (ml)"));
}

TEST_CASE("an option belongs to the command before it, else it begins one") {
    const std::string mesh = (std::filesystem::temp_directory_path() / "a b.stl").string();
    CHECK(lines_of(
              {"--crop", "0:9,0:9,0:9", "--surface", "bone", "--opacity", "0.5", "--light",
               "1 30 20", "--intensity", "2", "--clip", "L 5", "--export", mesh, "--keep", "0.5"},
              "phantom:pelvis") ==
          Lines{"light 1 30 20 intensity=2", "load phantom:pelvis crop=0:9,0:9,0:9",
                "surface bone opacity=0.5", "clip L 5", "view fit=yes", "snapshot " + picture_file,
                "export '" + mesh + "' keep=0.5"});
    CHECK(lines_of({"--opacity", "0.5"}, "phantom:pelvis")[1] == "surface bone opacity=0.5");
    CHECK(lines_of({"--preset", "bone"}, "a.nrrd")[1] == "surface surface preset=bone");
}

TEST_CASE("values and outputs are checked before anything is done") {
    CHECK_THROWS_WITH_AS(lines_of({"--opacity", "2"}, "phantom:pelvis"),
                         doctest::Contains("opacity: 2 is outside"), RequestError);
    CHECK_THROWS_WITH_AS(lines_of({"--export", "x.obj2"}, "phantom:pelvis"),
                         doctest::Contains("must end in .stl"), RequestError);
    CHECK_THROWS_WITH_AS(lines_of({}, "scan.nrrd"), doctest::Contains("--iso"), RequestError);
}
