#include "host/commands/command_options.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "host/base/error.hpp"
#include "host/base/part_file.hpp"
#include "host/phantom/phantom.hpp"
#include "host/session/transfer/scene_transfer.hpp"

namespace pxpl5::host {

namespace {

/// NAME=ISOVALUE[,COLOR]
Arguments short_surface(const std::string& text) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) {
        refuse_command(fmt::format(
            "--surface '{}' is neither NAME[=ISOVALUE[,COLOR]] nor words of 'surface'", text));
    }
    const std::size_t comma = text.find(',', equals);
    Arguments surface{"surface", {text.substr(0, equals)}, {}};
    surface.options["iso"] = text.substr(equals + 1, comma - equals - 1);
    if (comma != std::string::npos) {
        surface.options["color"] = text.substr(comma + 1);
    }
    return surface;
}

bool takes_one_file(const Command& command) {
    return command.words.size() == 1 &&
           (command.words[0].type == ValueType::output || command.words[0].type == ValueType::file);
}

std::string help_of(const Command& command) {
    std::string_view sentence = command.help.substr(0, command.help.find(". "));
    sentence.remove_suffix(sentence.ends_with('.') ? 1 : 0);
    return fmt::format("{}; {}", sentence, usage_of(command));
}

std::string help_of(const Parameter& parameter, const Command& command) {
    const bool has_unit = !parameter.unit.empty() && parameter.form != "MM";
    return fmt::format("{}: {}{}", command.name, parameter.help,
                       has_unit ? fmt::format(" ({})", parameter.unit) : "");
}

/// "MM", or "yes|no".
std::string form_shown(const Parameter& parameter) {
    return parameter.type == ValueType::choice
               ? fmt::format("{}", fmt::join(parameter.choices, "|"))
               : std::string(parameter.form);
}

}  // namespace

CommandOptions::CommandOptions(CLI::App& app, std::vector<RenderStage> stages, CommandTable table)
    : app_(app), stages_(std::move(stages)), table_(table) {
    for (const Command& command : table_) {
        if (!has_stage(command)) {
            continue;
        }
        if (!command.words.empty() && command.stage != RenderStage::load &&
            command.stage != RenderStage::picture) {
            declare(std::string(command.name), "WORDS", help_of(command), "Commands");
        }
        for (const Parameter& option : command.options) {
            declare(std::string(option.name), form_shown(option), help_of(option, command),
                    "Options of commands");
        }
    }
}

bool CommandOptions::has_stage(const Command& command) const {
    return std::ranges::find(stages_, command.stage) != stages_.end();
}

void CommandOptions::declare(const std::string& name, const std::string& form,
                             const std::string& help, const std::string& group) {
    if (app_.get_option_no_throw("--" + name) != nullptr) {
        return;  // The same key of two commands is one option.
    }
    CLI::Option* option = app_.add_option("--" + name, help);
    option->type_name(form)->expected(1)->group(group);
    option->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    names_[option] = name;
}

void CommandOptions::add_value(const std::string& name, const std::string& value,
                               std::vector<Arguments>& commands) const {
    const Command* command = known_command(table_, name);
    if (command != nullptr && has_stage(*command) && !command->words.empty()) {
        commands.push_back(command_of_option(*command, value));
        return;
    }
    const auto target = std::find_if(commands.rbegin(), commands.rend(), [&](const Arguments& c) {
        return find_option(find_command(c.name, table_), name) != nullptr && !c.has(name);
    });
    if (target != commands.rend()) {
        target->options[name] = value;
        return;
    }
    const Command* snapshot = known_command(table_, "snapshot");
    const bool draws = std::ranges::find(stages_, RenderStage::output) != stages_.end();
    if (snapshot != nullptr && draws && find_option(*snapshot, name) != nullptr) {
        commands.push_back({"snapshot", {}, {{name, value}}});  // Its file is that of `render`.
        return;
    }
    for (const Command& each : table_) {
        if (has_stage(each) && find_option(each, name) != nullptr) {
            if (each.required > 0 && each.name != "surface" &&
                (each.stage == RenderStage::scene || each.stage == RenderStage::output)) {
                refuse_command(fmt::format("--{} needs --{} {} before it", name, each.name,
                                           each.words.front().form));
            }
            commands.push_back({std::string(each.name), {}, {{name, value}}});
            return;
        }
    }
}

std::vector<Arguments> CommandOptions::commands() const {
    std::vector<Arguments> commands;
    std::map<const CLI::Option*, std::size_t> taken;
    for (const CLI::Option* option : app_.parse_order()) {
        if (const auto name = names_.find(option); name != names_.end()) {
            add_value(name->second, option->results().at(taken[option]++), commands);
        }
    }
    return commands;
}

Arguments command_of_option(const Command& command, const std::string& value) {
    if (takes_one_file(command)) {
        return {std::string(command.name), {value}, {}};
    }
    Arguments arguments = parse_line(std::string(command.name) + " " + value);
    const bool is_known = std::ranges::all_of(arguments.options, [&](const auto& option) {
        return find_option(command, option.first) != nullptr;
    });
    return command.name == "surface" && !is_known ? short_surface(value) : arguments;
}

void add_key_values(const std::vector<std::string>& words, Arguments& arguments) {
    for (const std::string& word : words) {
        const std::size_t equals = word.find('=');
        if (equals == std::string::npos || equals == 0) {
            refuse_command(
                fmt::format("unexpected argument '{}': options are KEY=VALUE, as series=2", word));
        }
        arguments.options[word.substr(0, equals)] = word.substr(equals + 1);
    }
}

namespace {

/// The surface that is drawn if none is named: as suggested for a built-in volume.
std::string usual_surface(const RenderRequest& request, const Arguments* wished) {
    const std::vector<PhantomSurface> suggested = suggested_surfaces(request.volume);
    const bool has_value = wished != nullptr && (wished->has("iso") || wished->has("preset"));
    return suggested.empty() || has_value ? "surface" : suggested.front().name;
}

/// Gives the surface without a name its name; adds the usual surface if there is none.
void name_surfaces(const RenderRequest& request, std::vector<Arguments>& commands) {
    bool has_surface = false;
    for (Arguments& each : commands) {
        has_surface |= each.name == "surface";
        if (each.name == "surface" && each.words.empty()) {
            each.words = {usual_surface(request, &each)};
        }
    }
    if (has_surface || is_archive(request.volume)) {
        return;
    }
    if (!is_phantom(request.volume)) {
        refuse_command(
            fmt::format("render needs --iso V or --surface NAME=V; 'pxpl5 info {}' "
                        "prints the values of the volume",
                        request.volume));
    }
    if (!suggested_surfaces(request.volume).empty()) {
        commands.insert(commands.begin(), {"surface", {usual_surface(request, nullptr)}, {}});
    }
}

/// The view of the picture shows the surfaces whole, unless the user chose its scale. An orbit
/// turns about the middle of the volume, so its view stays there.
///
/// commands  Named by the user. A wish for such a view is taken out: surfaces come later.
bool takes_fit(const RenderRequest& request, std::vector<Arguments>& commands) {
    bool is_chosen = is_archive(request.volume), is_wished = false;
    for (Arguments& each : commands) {
        if (each.name == "view") {
            is_wished |= each.text("fit", "no") == "yes";
            is_chosen |= each.has("zoom") || each.has("pan") || each.text("fit", "yes") == "no";
            each.options.erase("fit");
        }
        is_chosen |= each.name == "orbit";
    }
    std::erase_if(commands, [](const Arguments& each) {
        return each.name == "view" && each.words.empty() && each.options.empty();
    });
    return is_wished || !is_chosen;
}

}  // namespace

bool is_pair_in_one(const std::string& path) {
    return suffix_of(path) == ".jps";
}

bool is_pair_in_two(const std::string& path) {
    return suffix_of(path) == ".mpo";
}

void check_eyes(std::string_view command, const std::string& path, bool is_stereo) {
    if (!is_stereo && (is_pair_in_one(path) || is_pair_in_two(path))) {
        refuse_command(
            fmt::format("{}: {} holds a picture for each eye, but stereo is off. "
                        "Type `stereo sbs` first, or write a .png. For pxpl5 render: --stereo sbs",
                        command, path));
    }
}

std::vector<Arguments> render_commands(const RenderRequest& request, CommandTable table) {
    std::vector<Arguments> named = request.commands;
    name_surfaces(request, named);
    const bool fits = takes_fit(request, named);
    const auto of_stage = [&](RenderStage stage, std::vector<Arguments>& into) {
        std::ranges::copy_if(named, std::back_inserter(into), [&](const Arguments& each) {
            return find_command(each.name, table).stage == stage;
        });
    };
    std::vector<Arguments> loads, all;
    of_stage(RenderStage::load, loads);
    Arguments load{"load",
                   {request.volume},
                   loads.empty() ? std::map<std::string, std::string>() : loads.front().options};
    add_key_values(request.load_words, load);
    of_stage(RenderStage::look, all);
    all.push_back(load);
    of_stage(RenderStage::scene, all);
    if (fits) {
        all.push_back({"view", {}, {{"fit", "yes"}}});
    }
    const auto snapshot = std::ranges::find(named, "snapshot", &Arguments::name);
    all.push_back(
        {"snapshot",
         {request.output},
         snapshot == named.end() ? std::map<std::string, std::string>() : snapshot->options});
    of_stage(RenderStage::output, all);
    for (const Arguments& each : all) {
        check_arguments(find_command(each.name, table), each);
    }
    const auto chosen = std::ranges::find(all, "stereo", &Arguments::name);
    check_eyes("render", request.output,
               chosen != all.end() && !chosen->words.empty() && chosen->words.front() != "off");
    return all;
}

}  // namespace pxpl5::host
