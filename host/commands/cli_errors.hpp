// Errors of the shell's command line, with the nearest known subcommand or option.
#pragma once

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace pxpl5::host {

/// Prints the help that was asked for, or the error with a hint. Returns the exit code.
int report_parse_error(const CLI::App& app, const CLI::ParseError& error);

}  // namespace pxpl5::host
