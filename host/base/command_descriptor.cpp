#include "host/base/command_descriptor.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>

#include "host/base/error.hpp"
#include "host/base/part_file.hpp"

namespace pxpl5::host {

namespace {

constexpr std::array<std::string_view, 7> type_names = {"text",  "number", "whole", "choice",
                                                        "color", "file",   "output"};
constexpr std::array<std::string_view, 4> kind_names = {"question", "setting", "action", "memory"};

bool is_number(const Parameter& parameter) {
    return parameter.type == ValueType::number || parameter.type == ValueType::whole;
}

/// "V", or "yes|no".
std::string form_of(const Parameter& parameter) {
    return parameter.type == ValueType::choice
               ? fmt::format("{}", fmt::join(parameter.choices, "|"))
               : std::string(parameter.form);
}

std::string range_of(const Parameter& parameter) {
    return std::abs(parameter.low) < max_float && std::abs(parameter.high) < max_float
               ? fmt::format("{} to {}", parameter.low, parameter.high)
               : "";
}

/// "    iso=V          isovalue (0 to 4; default 1)".
std::string parameter_line(const Parameter& parameter, bool is_option) {
    std::vector<std::string> notes;
    if (is_number(parameter)) {
        const std::string range = range_of(parameter);
        if (!range.empty() || !parameter.unit.empty()) {
            notes.push_back(range + (range.empty() || parameter.unit.empty() ? "" : " ") +
                            std::string(parameter.unit));
        }
    }
    if (!parameter.usual.empty()) {
        notes.push_back("default " + std::string(parameter.usual));
    }
    if (parameter.type == ValueType::output) {
        notes.push_back(fmt::format("{}", fmt::join(parameter.choices, " ")));
    }
    const std::string key =
        is_option ? fmt::format("{}={}", parameter.name, form_of(parameter)) : form_of(parameter);
    return fmt::format("\n    {:<16} {}{}", key, parameter.help,
                       notes.empty() ? "" : fmt::format(" ({})", fmt::join(notes, "; ")));
}

std::vector<std::string_view> keys_of(const CommandDescriptor& command) {
    std::vector<std::string_view> keys;
    std::ranges::transform(command.options, std::back_inserter(keys), &Parameter::name);
    return keys;
}

/// A name or a path with a line break would be two lines of a script.
void check_printable(const CommandDescriptor& command, const Parameter& parameter,
                     const std::string& text) {
    const bool has_control =
        std::ranges::any_of(text, [](unsigned char c) { return c < ' ' || c == 0x7F; });
    if (has_control) {
        const bool is_path = parameter.type != ValueType::text;
        refuse_command(fmt::format("{}: {} has a control character, for example a line break{}",
                                   command.name, parameter.name,
                                   is_path ? "; rename the file or the folder" : ""));
    }
}

void check_value(const CommandDescriptor& command, const Parameter& parameter,
                 const std::string& text) {
    const std::string what = fmt::format("{}: {}", command.name, parameter.name);
    switch (parameter.type) {
        case ValueType::number:
            parse_number(what, text, parameter.low, parameter.high);
            break;
        case ValueType::whole:
            parse_whole(what, text, static_cast<int>(parameter.low),
                        static_cast<int>(parameter.high));
            break;
        case ValueType::choice:
            if (std::ranges::find(parameter.choices, text) == parameter.choices.end()) {
                refuse_command(fmt::format("{}: {} cannot be '{}'{}", command.name, parameter.name,
                                           text, did_you_mean(text, parameter.choices)));
            }
            break;
        case ValueType::color:
            parse_color(text);
            break;
        case ValueType::output:
            check_printable(command, parameter, text);
            check_output(command.name, text, parameter.choices);
            break;
        case ValueType::text:
        case ValueType::file:
            check_printable(command, parameter, text);
            break;
        default:
            break;
    }
}

/// "write iso=0, not --iso 0" where a word looks like an option of a shell command.
std::string dialect_hint(const CommandDescriptor& command, const Arguments& arguments) {
    for (std::size_t i = 0; i < arguments.words.size(); ++i) {
        const std::string& word = arguments.words[i];
        if (word.starts_with("--") && find_option(command, word.substr(2)) != nullptr) {
            const std::string value =
                i + 1 < arguments.words.size() ? arguments.words[i + 1] : "VALUE";
            return fmt::format("; write {0}={1}, not {2} {1}", word.substr(2), value, word);
        }
    }
    return "";
}

void check_count(const CommandDescriptor& command, const Arguments& arguments) {
    const std::size_t count = arguments.words.size(), most = command.words.size();
    if (count >= command.required && count <= most) {
        return;
    }
    const std::string range = command.required == most
                                  ? fmt::format("{}", most)
                                  : fmt::format("{} to {}", command.required, most);
    refuse_command(fmt::format("{} takes {} word{}, but {} {} given{}; usage: {}", command.name,
                               most == 0 ? "no" : range, most == 1 ? "" : "s", count,
                               count == 1 ? "is" : "are", dialect_hint(command, arguments),
                               usage_of(command)));
}

Fields parameter_fields(const Parameter& parameter) {
    Fields fields = {{"name", std::string(parameter.name)},
                     {"form", form_of(parameter)},
                     {"type", std::string(type_names[static_cast<std::size_t>(parameter.type)])},
                     {"help", std::string(parameter.help)}};
    if (is_number(parameter)) {
        fields.push_back({"minimum", parameter.low});
        fields.push_back({"maximum", parameter.high});
    }
    if (!parameter.unit.empty()) {
        fields.push_back({"unit", std::string(parameter.unit)});
    }
    if (!parameter.usual.empty()) {
        fields.push_back({"default", std::string(parameter.usual)});
    }
    return fields;
}

std::vector<Fields> list_of(const std::vector<Parameter>& parameters) {
    std::vector<Fields> list;
    std::ranges::transform(parameters, std::back_inserter(list), parameter_fields);
    return list;
}

/// The words after the name in a usage line.
std::string arguments_of(const CommandDescriptor& command) {
    std::string text(command.forms);
    if (text.empty()) {
        for (std::size_t i = 0; i < command.words.size(); ++i) {
            const std::string form = form_of(command.words[i]);
            text += (i == 0 ? "" : " ") + (i < command.required ? form : "[" + form + "]");
        }
    }
    const bool lists_options = command.forms.ends_with("...]");
    for (const Parameter& option : command.options) {
        text += lists_options ? ""
                              : fmt::format("{}[{}={}]", text.empty() ? "" : " ", option.name,
                                            form_of(option));
    }
    return text;
}

}  // namespace

std::string usage_of(const CommandDescriptor& command) {
    const std::string arguments = arguments_of(command);
    return std::string(command.name) + (arguments.empty() ? "" : " ") + arguments;
}

std::string full_help(const CommandDescriptor& command) {
    std::string text = fmt::format("{}\n    {}", usage_of(command), command.help);
    for (const Parameter& word : command.words) {
        text += word.help.empty() ? "" : parameter_line(word, false);
    }
    for (const Parameter& option : command.options) {
        text += parameter_line(option, true);
    }
    return text;
}

Fields descriptor_fields(const CommandDescriptor& command) {
    return {{"name", std::string(command.name)},
            {"arguments", arguments_of(command)},
            {"help", std::string(command.help)},
            {"kind", std::string(kind_names[static_cast<std::size_t>(command.kind)])},
            {"subject_words", static_cast<std::int64_t>(command.subject_words)},
            {"long", command.is_long},
            {"words", list_of(command.words)},
            {"options", list_of(command.options)}};
}

const Parameter* find_option(const CommandDescriptor& command, std::string_view key) {
    const auto found = std::ranges::find(command.options, key, &Parameter::name);
    return found == command.options.end() ? nullptr : &*found;
}

void check_arguments(const CommandDescriptor& command, const Arguments& arguments) {
    check_count(command, arguments);
    for (std::size_t i = 0; i < arguments.words.size(); ++i) {
        check_value(command, command.words[i], arguments.words[i]);
    }
    for (const auto& [key, value] : arguments.options) {
        const Parameter* option = find_option(command, key);
        if (option == nullptr) {
            refuse_command(fmt::format("{} has no option '{}'{}", command.name, key,
                                       command.options.empty()
                                           ? fmt::format("; usage: {}", usage_of(command))
                                           : did_you_mean(key, keys_of(command))));
        }
        check_value(command, *option, value);
    }
}

void check_output(std::string_view command, const std::string& path,
                  std::span<const std::string_view> suffixes) {
    std::error_code absent;
    if (std::filesystem::is_directory(path, absent)) {  // More useful than a word on its suffix.
        throw RequestError(ExitCode::failed, wrong_place(path));
    }
    const std::filesystem::file_status there = std::filesystem::status(path, absent);
    if (suffixes.empty() && exists(there) && !is_regular_file(there)) {
        return;  // A script may go to a device, for example to /dev/stdout.
    }
    const std::string suffix = suffix_of(path);
    if (!suffixes.empty() && std::ranges::find(suffixes, suffix) == suffixes.end()) {
        refuse_command(
            fmt::format("{}: '{}' must end in {}", command, path, fmt::join(suffixes, ", ")));
    }
    if (const std::string wrong = wrong_place(path); !wrong.empty()) {
        throw RequestError(ExitCode::failed, wrong);
    }
    const std::filesystem::path folder = place_of(path).parent_path();
    if (access(folder.empty() ? "." : folder.c_str(), W_OK) != 0) {
        throw RequestError(ExitCode::failed,
                           fmt::format("{}: its folder {} cannot be written", path,
                                       folder.empty() ? "." : folder.string()));
    }
}

}  // namespace pxpl5::host
