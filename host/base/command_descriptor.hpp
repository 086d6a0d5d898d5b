// Describes a command's words and options. Parsing, help, the options of `render`, JSON and the
// page's table derive from the descriptors.
#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/command_line.hpp"
#include "host/base/nearest.hpp"
#include "host/base/reply.hpp"

namespace pxpl5::host {

/// `output` is a file to write: its folder and its suffix are checked before any work.
enum class ValueType : std::uint8_t { text, number, whole, choice, color, file, output };

/// A word or an option of a command.
struct Parameter {
    std::string_view name;  ///< Key of an option.
    std::string_view form;  ///< The value in usage lines, for example "X,Y".
    std::string_view help;  ///< A phrase without a full stop.
    ValueType type = ValueType::text;
    double low = 0, high = 0;                        ///< Range of a number.
    std::string_view unit = {}, usual = {};          ///< `usual` is the default in words.
    std::span<const std::string_view> choices = {};  ///< Words, or the suffixes of an output.
};

/// Effect of a command on the session.
enum class CommandKind : std::uint8_t {
    question,  ///< Changes nothing, unless an option says so.
    setting,   ///< A later setting of the same subject replaces an earlier one.
    action,    ///< All commands before it must be done first.
    memory     ///< Acts on the history and is no part of it.
};

/// When `render` runs a command that its options name.
enum class RenderStage : std::uint8_t { never, look, load, scene, picture, output };

struct CommandDescriptor {
    std::string_view name;
    std::string_view help;  ///< Sentences.
    std::vector<Parameter> words = {};
    std::size_t required = 0;  ///< The first words, which may not be left out.
    std::vector<Parameter> options = {};
    std::string_view forms = {};  ///< Usage of the words if they have several forms.
    CommandKind kind = CommandKind::question;
    std::size_t subject_words = 0;  ///< Number of words that name the subject of a setting.
    bool is_long = false;           ///< Shows progress and can be canceled.
    RenderStage stage = RenderStage::never;
    std::vector<std::string_view> aliases = {};
    /// The further files that appear beside the output `file`.
    std::vector<std::string> (*files_beside)(const std::string& file) = nullptr;
};

/// Isovalues and gray values beyond this are no floats.
inline constexpr double max_float = std::numeric_limits<float>::max();

constexpr Parameter number_value(std::string_view name, std::string_view form, double low,
                                 double high, std::string_view help, std::string_view unit = {}) {
    return {name, form, help, ValueType::number, low, high, unit};
}
constexpr Parameter whole_value(std::string_view name, std::string_view form, double low,
                                double high, std::string_view help, std::string_view usual = {}) {
    return {name, form, help, ValueType::whole, low, high, {}, usual};
}
constexpr Parameter choice_value(std::string_view name, std::span<const std::string_view> choices,
                                 std::string_view help, std::string_view usual = {}) {
    return {name, {}, help, ValueType::choice, 0, 0, {}, usual, choices};
}
constexpr Parameter output_value(std::string_view name, std::span<const std::string_view> suffixes,
                                 std::string_view help) {
    return {name, name, help, ValueType::output, 0, 0, {}, {}, suffixes};
}

/// "surface NAME [iso=V] [opacity=SHARE]".
std::string usage_of(const CommandDescriptor& command);
/// The usage, the help and one line for each word and option.
std::string full_help(const CommandDescriptor& command);
/// Everything that the descriptor states, as a program reads it.
Fields descriptor_fields(const CommandDescriptor& command);

/// The option with that key. Null if the command has none.
const Parameter* find_option(const CommandDescriptor& command, std::string_view key);

/// Checks count, type and range of all words and options, and where outputs go.
/// Throws RequestError (usage) that names the word or option and its value.
void check_arguments(const CommandDescriptor& command, const Arguments& arguments);

/// Checks the suffix of an output, and that its folder exists and can be written. A pattern may
/// have "{}" in its name. Throws RequestError (usage: suffix; failed: folder).
void check_output(std::string_view command, const std::string& path,
                  std::span<const std::string_view> suffixes);

/// The element of a table whose name or alias is `name`. Null if there is none.
template <typename C>
const C* known_command(std::span<const C> table, std::string_view name) {
    const auto found = std::ranges::find_if(table, [name](const C& command) {
        return command.name == name ||
               std::ranges::find(command.aliases, name) != command.aliases.end();
    });
    return found == table.end() ? nullptr : &*found;
}

/// The same. Throws RequestError (usage) with the nearest name if there is none.
template <typename C>
const C& find_in(std::span<const C> table, std::string_view name) {
    if (const C* command = known_command(table, name)) {
        return *command;
    }
    std::vector<std::string_view> names;
    std::ranges::transform(table, std::back_inserter(names), &C::name);
    const std::string guess = did_you_mean(name, names);
    refuse_command(
        "there is no command '" + std::string(name) + "'" + guess +
        (guess.ends_with('?') ? " 'help' lists the commands" : "; 'help' lists the commands"));
}

/// `help`: usage and help of all commands; everything about one if it is named.
template <typename C>
Reply help_reply(std::span<const C> table, const Arguments& arguments) {
    Reply reply;
    std::vector<Fields> list;
    if (!arguments.words.empty()) {
        const C& command = find_in(table, arguments.words[0]);
        reply.text = full_help(command);
        list.push_back(descriptor_fields(command));
    } else {
        for (const C& command : table) {
            reply.text += (reply.text.empty() ? "" : "\n") + usage_of(command) + "\n    " +
                          std::string(command.help);
            list.push_back(descriptor_fields(command));
        }
    }
    reply.fields = {{"commands", list}};
    return reply;
}

}  // namespace pxpl5::host
