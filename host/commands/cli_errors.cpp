#include "host/commands/cli_errors.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <optional>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/kernel/standard_streams.hpp"
#include "host/base/nearest.hpp"
#include "host/commands/commands.hpp"

namespace pxpl5::host {

namespace {

/// The subcommand that was parsed last, or the program.
const CLI::App& innermost(const CLI::App& app) {
    const std::vector<CLI::App*> parsed = app.get_subcommands();
    return parsed.empty() ? app : innermost(*parsed.back());
}

std::string nearest_of(const std::string& word, const std::vector<std::string>& names) {
    const std::vector<std::string_view> views(names.begin(), names.end());
    return did_you_mean(word, views);
}

/// Groups of options are subcommands without a name.
std::vector<std::string> subcommands_of(const CLI::App& app) {
    std::vector<std::string> names;
    const auto is_named = [](const CLI::App* each) { return !each->get_name().empty(); };
    for (const CLI::App* each : app.get_subcommands(is_named)) {
        names.push_back(each->get_name());
    }
    return names;
}

std::vector<std::string> options_of(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::Option* each : app.get_options()) {
        for (const std::string& name : each->get_lnames()) {
            names.push_back("--" + name);
        }
    }
    return names;
}

/// "VOLUME", "[SCRIPT]", "[KEY=VALUE ...]".
std::string placeholder_of(const CLI::Option& positional) {
    std::string text = positional.get_name(true);
    std::ranges::transform(text, text.begin(),
                           [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    text = text == "OPTIONS" ? "KEY=VALUE" : text;
    text += positional.get_items_expected_max() > 1 ? " ..." : "";
    return positional.get_required() ? text : "[" + text + "]";
}

/// "pxpl5 render VOLUME [KEY=VALUE ...] -o FILE".
std::string usage_line(const CLI::App& app) {
    std::string text = app.get_parent() == nullptr ? "" : usage_line(*app.get_parent()) + " ";
    text += app.get_name();
    std::string required;
    for (const CLI::Option* each : app.get_options()) {
        if (each->get_positional()) {
            text += " " + placeholder_of(*each);
        } else if (each->get_required() && !each->get_snames().empty()) {
            required += " -" + each->get_snames().front() + " FILE";
        }
    }
    return text + required;
}

/// An option that took the name of the next option for its value.
std::optional<std::string> taken_option_error(const CLI::App& app) {
    for (const CLI::Option* each : app.get_options()) {
        for (const std::string& value : each->results()) {
            if (value.starts_with("-") && app.get_option_no_throw(value) != nullptr) {
                return fmt::format("{} needs a value {}; found '{}'", each->get_name(),
                                   each->get_type_name(), value);
            }
        }
    }
    return std::nullopt;
}

/// Words of the library in the words of this program: "--surface = bone" is no number.
std::string reason_of(const CLI::ParseError& error) {
    std::string text = error.what();
    constexpr std::string_view not_converted = "Could not convert: ";
    const std::size_t equals = text.find(" = ");
    if (!text.starts_with(not_converted) || equals == std::string::npos) {
        return text;
    }
    return fmt::format("{} must be a number, but is '{}'",
                       text.substr(not_converted.size(), equals - not_converted.size()),
                       text.substr(equals + 3));
}

/// The first word that nothing takes; nothing if all words were taken.
std::optional<std::string> surplus_error(const CLI::App& app) {
    const CLI::App& inner = innermost(app);
    std::vector<std::string> surplus = app.remaining(true);
    if (surplus.empty()) {
        return std::nullopt;
    }
    const std::string& first = surplus.front();
    if (first.starts_with("-") && inner.get_option_no_throw(first) != nullptr) {
        return fmt::format("'{}' goes behind '{}', whose option it is: {} {}", first,
                           inner.get_name(), usage_line(inner), first);
    }
    if (first.starts_with("-")) {
        return fmt::format("{} has no option '{}'{}", inner.get_name(), first,
                           nearest_of(first, options_of(inner)));
    }
    if (app.get_subcommands().empty() && known_command(command_table(), first) != nullptr) {
        return fmt::format("'{0}' is a command: pxpl5 run -c \"{1}{0} ...\"", first,
                           first == "load" ? "" : "load FILE; ");
    }
    const std::vector<std::string> subcommands = subcommands_of(inner);
    return subcommands.empty() ? fmt::format("{}: unexpected argument '{}'; usage: {}",
                                             inner.get_name(), first, usage_line(inner))
                               : fmt::format("{} has no subcommand '{}'{}", inner.get_name(), first,
                                             nearest_of(first, subcommands));
}

}  // namespace

int report_parse_error(const CLI::App& app, const CLI::ParseError& error) {
    const bool is_help = error.get_exit_code() == 0;
    std::optional<std::string> surplus = surplus_error(app);
    if (!is_help && !surplus) {
        surplus = taken_option_error(innermost(app));
    }
    if (is_help && !surplus) {
        return app.exit(error);
    }
    const CLI::App& inner = innermost(app);
    if (surplus) {
        print_error(*surplus, 0);
    } else if (inner.get_require_subcommand_min() > 0) {
        fmt::print(stderr,
                   "error: {} needs a subcommand: {}\nRun with --help for more information.\n",
                   inner.get_name(), fmt::join(subcommands_of(inner), ", "));
    } else {
        fmt::print(stderr, "error: {}: {}\nusage: {}\nRun with --help for more information.\n",
                   inner.get_name(), printable(reason_of(error)), usage_line(inner));
    }
    return static_cast<int>(ExitCode::usage);
}

}  // namespace pxpl5::host
