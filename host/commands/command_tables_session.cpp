// Rows of commands about pictures, the machine and the session itself.
#include <array>

#include "generated/vocabulary.hpp"
#include "host/commands/command_handlers.hpp"
#include "host/commands/command_tables.hpp"
#include "host/film/film.hpp"

namespace pxpl5::host {

namespace {

constexpr std::array<std::string_view, 1> save_choice = {"save"};
constexpr std::array<std::string_view, 3> computers_choices = {"use", "release", "invite"};
constexpr std::array<std::string_view, 7> snapshot_suffixes = {".png", ".tif", ".tiff", ".exr",
                                                               ".gif", ".jps", ".mpo"};
constexpr Words script_forms = {"steps", "scene"};

constexpr Parameter delay = number_value(
    "delay_ms", "D", 10, 60'000, "time between the pictures of a .gif; 40 by default", "ms");
constexpr Parameter rate = number_value("rate", "R", film::min_rate, film::max_rate,
                                        "frames per second of a .webm; 25 by default", "frames/s");
constexpr std::array<std::string_view, 6> pattern_suffixes = {".png", ".tif", ".tiff",
                                                              ".exr", ".gif", ".webm"};
constexpr Parameter pattern = {"PATTERN",
                               "PATTERN|FILE.webm|FILE.gif",
                               "files with {} for the number, a film, or an animation",
                               ValueType::output,
                               0,
                               0,
                               {},
                               {},
                               pattern_suffixes};
constexpr Parameter delay_of_volumes =
    number_value("delay_ms", "D", 10, 60'000,
                 "time between the pictures of a .gif; by default that of the volumes", "ms");
constexpr Parameter rate_of_volumes =
    number_value("rate", "R", film::min_rate, film::max_rate,
                 "frames per second of a .webm; by default in real time", "frames/s");
constexpr Parameter size_of_pictures = {"size", "WIDTHxHEIGHT", "size of these pictures"};
constexpr Parameter samples_of_pictures = {"samples", "1|4|16",
                                           "samples per pixel of these pictures"};
constexpr Parameter ground_of_pictures = {"ground", "shown|COLOR", "background of these pictures"};
constexpr double max_turn_deg = 36'000;

constexpr Parameter scale_option(std::string_view name, std::string_view help) {
    return {name, "+N|-N|N", help};
}

}  // namespace

std::vector<Command> picture_commands() {
    return {
        {{.name = "snapshot",
          .help = "Draws the scene and writes the picture. A .jps or .mpo has a picture for each "
                  "eye, whatever stereo shows; stereo must not be off.",
          .words = {output_value("FILE", snapshot_suffixes, "picture to write")},
          .required = 1,
          .options = {{"size", "WIDTHxHEIGHT", "size of this picture"},
                      {"samples", "1|4|16", "samples per pixel of this picture"},
                      choice_value("overlay", on_off, "marks of this picture"),
                      {"ground", "shown|transparent|COLOR",
                       "background of this picture; transparent: of a .png or .tif"}},
          .kind = CommandKind::action,
          .is_long = true,
          .stage = RenderStage::picture},
         run_snapshot},
        {{.name = "orbit",
          .help = "Draws N views around the volume and writes them.",
          .words = {whole_value("N", "N", 1, 100'000, "number of views"), pattern},
          .required = 1,
          .options = {number_value("degrees", "D", -max_turn_deg, max_turn_deg,
                                   "turn of the view; 360 by default", "degrees"),
                      delay, rate, size_of_pictures, samples_of_pictures, ground_of_pictures,
                      whole_value("inflight", "N", 1, max_frames_in_flight,
                                  "frames drawn at the same time", "2")},
          .kind = CommandKind::action,
          .is_long = true,
          .stage = RenderStage::output},
         run_orbit},
        {{.name = "sweep",
          .help = "Moves the isovalue of a surface in N steps, draws each step and writes the "
                  "pictures. Afterwards the surface has its old isovalue; a comparison ends.",
          .words = {{"NAME", "NAME", "name of a surface"},
                    number_value("FROM", "FROM", -max_float, max_float, "first isovalue"),
                    number_value("TO", "TO", -max_float, max_float, "last isovalue"),
                    whole_value("N", "N", 2, 100'000, "number of isovalues"),
                    pattern},
          .required = 4,
          .options = {delay, rate, size_of_pictures, samples_of_pictures, ground_of_pictures},
          .kind = CommandKind::action,
          .is_long = true,
          .stage = RenderStage::output},
         run_sweep},
        {{.name = "cine",
          .help = "Draws each volume of a time series and writes the pictures; {} is the number of "
                  "the volume. A .webm or .gif is in real time if the volumes are 17 to 200 ms "
                  "apart, else it has 25 volumes per second.",
          .words = {pattern},
          .options = {first_volume, last_volume, delay_of_volumes, rate_of_volumes,
                      size_of_pictures, samples_of_pictures, ground_of_pictures},
          .kind = CommandKind::action,
          .is_long = true,
          .stage = RenderStage::output},
         run_cine},
    };
}

std::vector<Command> machine_commands() {
    return {
        {{.name = "stats",
          .help = "Prints counts of the surfaces, the machine and the last frame."},
         run_stats},
        {{.name = "activity",
          .help = "Prints the work of each node since the previous 'activity'."},
         run_activity},
        {{.name = "kill",
          .help = "Kills a node (for example gp-1) to exercise failure handling.",
          .words = {{"NODE", "NODE", "name of a node"}},
          .required = 1},
         run_kill},
        {{.name = "scale",
          .help = "Adds or retires GPs and Renderers: gp=+2, renderer=-1, or a count.",
          .options = {scale_option("gp", "GPs to add or to retire, or their count"),
                      scale_option("renderer", "Renderers to add or to retire, or their count")},
          .is_long = true},
         run_scale},
        {{.name = "computers",
          .help = "Lists the other computers of the machine. use: places the nodes again, on all "
                  "that have joined; with NAME, starts pxpl5 there before. release: moves the "
                  "nodes of NAME to the others and ends pxpl5 there. invite: prints the line that "
                  "lets one more computer join.",
          .words = {choice_value("ACTION", computers_choices, "what to do"),
                    {"NAME", "NAME", "name of a computer"}},
          .forms = "[use [NAME] | release NAME | invite]",
          .is_long = true},
         run_computers},
        {{.name = "model",
          .help = "Prints the modelled time to load the volume, to build the surfaces and to draw "
                  "the scene on another machine, and the busiest unit. Draws the scene once.",
          .words = {{"MACHINE",
                     "MACHINE",
                     "topology: a name or a file",
                     ValueType::file,
                     0,
                     0,
                     {},
                     "paper-1993"}},
          .options = model_options(),
          .forms = "[MACHINE] [PARAMETER=VALUE ...]"},
         run_model},
        {{.name = "digest", .help = "Prints a digest of the frame and of each mesh."}, run_digest},
        {{.name = "trace",
          .help = "Writes the traces of all nodes to files.",
          .words = {choice_value("save", save_choice, "")},
          .required = 1,
          .kind = CommandKind::action},
         run_trace},
    };
}

std::vector<Command> session_commands() {
    return {
        {{.name = "undo",
          .help = "Undoes the last change of the scene.",
          .kind = CommandKind::memory},
         run_undo},
        {{.name = "redo", .help = "Redoes the last undone change.", .kind = CommandKind::memory},
         run_redo},
        {{.name = "mark", .help = "Starts a new undo step.", .kind = CommandKind::memory},
         run_mark},
        {{.name = "history",
          .help =
              "Prints a script that repeats the session, or writes it to FILE. form=scene makes "
              "the present scene only, and refuses another volume than the present one.",
          .words = {output_value("FILE", {}, "script to write")},
          .options = {choice_value("form", script_forms, "contents of the script", "steps")}},
         run_history},
        {{.name = "play",
          .help = "Runs a script.",
          .words = {{"FILE", "FILE", "script", ValueType::file}},
          .required = 1,
          .kind = CommandKind::memory,
          .is_long = true},
         run_play},
        {{.name = "help",
          .help = "Lists the commands, or explains one.",
          .words = {{"COMMAND", "COMMAND", "name of a command"}}}},
        {{.name = "quit", .help = "Ends the session.", .kind = CommandKind::memory}, run_quit},
    };
}

}  // namespace pxpl5::host
