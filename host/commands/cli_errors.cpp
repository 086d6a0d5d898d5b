#include "host/commands/cli_errors.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/nearest.hpp"

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

std::vector<std::string> subcommands_of(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::App* each : app.get_subcommands([](const CLI::App*) { return true; })) {
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

/// "pxpl5 why run x y".
std::string usage_line(const CLI::App& app) {
    std::string text = app.get_parent() == nullptr ? "" : usage_line(*app.get_parent()) + " ";
    text += app.get_name();
    for (const CLI::Option* each : app.get_options()) {
        if (each->get_positional()) {
            text += " " + each->get_name(true);
        }
    }
    return text;
}

/// The first word that nothing takes; nothing if all words were taken.
std::optional<std::string> surplus_error(const CLI::App& app) {
    const CLI::App& inner = innermost(app);
    std::vector<std::string> surplus = app.remaining(true);
    if (surplus.empty()) {
        return std::nullopt;
    }
    const std::string& first = surplus.front();
    if (first.starts_with("-")) {
        return fmt::format("{} has no option '{}'{}", inner.get_name(), first,
                           nearest_of(first, options_of(inner)));
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
    const std::optional<std::string> surplus = surplus_error(app);
    if (is_help && !surplus) {
        return app.exit(error);
    }
    const CLI::App& inner = innermost(app);
    if (surplus) {
        fmt::print(stderr, "error: {}\n", *surplus);
    } else {
        fmt::print(stderr, "error: {}: {}\nusage: {}\nRun with --help for more information.\n",
                   inner.get_name(), error.what(), usage_line(inner));
    }
    return static_cast<int>(ExitCode::usage);
}

}  // namespace pxpl5::host
