#include "host/commands.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "host/command_handlers.hpp"
#include "host/error.hpp"
#include "host/nearest.hpp"

namespace pxpl5::host {

std::span<const Command> command_table() {
    static const std::vector<Command> table = {
        {"load",
         "FILE|FOLDER|phantom:NAME|SCENE.phigs",
         "Reads a volume, or a PPHIGS archive, and hands it to the GPs.",
         1,
         1,
         {},
         run_load},
        {"info",
         "[VOLUME]",
         "Tells what is known of the loaded volume, or of another.",
         0,
         1,
         {},
         run_info},
        {"surface",
         "NAME [iso=V] [color=C] [table=watertight|lorensen1987|asymptotic]",
         "Adds a surface, or changes its isovalue or colour.",
         1,
         1,
         {"iso", "color", "table"},
         run_surface},
        {"remove", "NAME", "Removes a surface.", 1, 1, {}, run_remove},
        {"view",
         "anterior|posterior|left|right|superior|inferior|AZ EL [zoom=Z]",
         "Places the viewer; angles in degrees, azimuth 90 is the patient's left.",
         0,
         2,
         {"zoom"},
         run_view},
        {"light",
         "N AZ EL [intensity=I] | N off",
         "Sets directional light N (1..4) as seen by the viewer.",
         2,
         3,
         {"intensity"},
         run_light},
        {"material",
         "[ambient=A] [specular=S] [power=P]",
         "Sets how surfaces reflect.",
         0,
         0,
         {"ambient", "specular", "power"},
         run_material},
        {"background", "COLOUR", "Sets the colour behind the surfaces.", 1, 1, {}, run_background},
        {"size", "WIDTHxHEIGHT", "Sets the size of pictures in pixels.", 1, 1, {}, run_size},
        {"snapshot",
         "FILE",
         "Draws the scene and writes the picture (.png, .tif or .exr).",
         1,
         1,
         {},
         run_snapshot},
        {"orbit",
         "N [PATTERN]",
         "Draws N views around the volume; writes them where PATTERN has {} for the number.",
         1,
         2,
         {},
         run_orbit},
        {"stats", "", "Tells what the machine has done so far.", 0, 0, {}, run_stats},
        {"digest", "", "Prints fingerprints of the frame and of each mesh.", 0, 0, {}, run_digest},
        {"trace", "save", "Writes the traces of all nodes to files.", 1, 1, {}, run_trace},
        {"help", "[COMMAND]", "Lists the commands, or explains one.", 0, 1, {}, run_help},
        {"quit", "", "Ends the session.", 0, 0, {}, run_quit},
    };
    return table;
}

const Command& find_command(std::string_view name) {
    std::vector<std::string_view> names;
    for (const Command& command : command_table()) {
        if (command.name == name) {
            return command;
        }
        names.push_back(command.name);
    }
    throw RequestError(ExitCode::usage,
                       fmt::format("there is no command '{}'{}", name, did_you_mean(name, names)));
}

Reply run_command(Session& session, const Arguments& arguments) {
    const Command& command = find_command(arguments.name);
    if (arguments.words.size() < command.min_words || arguments.words.size() > command.max_words) {
        throw RequestError(ExitCode::usage,
                           fmt::format("{} takes {}{} word(s), {} given; usage: {} {}",
                                       command.name, command.min_words,
                                       command.max_words == command.min_words
                                           ? std::string()
                                           : fmt::format(" to {}", command.max_words),
                                       arguments.words.size(), command.name, command.arguments));
    }
    for (const auto& [key, value] : arguments.options) {
        if (std::find(command.options.begin(), command.options.end(), key) ==
            command.options.end()) {
            throw RequestError(
                ExitCode::usage,
                fmt::format("{} knows no option '{}={}'{}", command.name, key, value,
                            command.options.empty() ? "; it takes none"
                                                    : did_you_mean(key, command.options)));
        }
    }
    return command.run(session, arguments);
}

}  // namespace pxpl5::host
