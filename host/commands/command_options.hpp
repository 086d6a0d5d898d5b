// The long options of a subcommand that stand for commands of the table: `--light "1 30 20"` is
// the command `light 1 30 20`, and `--opacity 0.4` is its option opacity=0.4.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "host/commands/commands.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace pxpl5::host {

/// Declares --NAME for each command of some stages and --KEY for each option of these commands.
/// Commands of the stages load and picture have no --NAME: `render` names their files itself.
class CommandOptions {
  public:
    CommandOptions(CLI::App& app, std::vector<RenderStage> stages,
                   CommandTable table = command_table());

    /// The commands of the parsed command line, in the order given. A --KEY belongs to the nearest
    /// command before it that has this option and no value for it yet. If none exists, it begins
    /// the first command of the table that has this option, without words.
    /// Throws RequestError (usage) for a value that is no command.
    std::vector<Arguments> commands() const;

  private:
    bool has_stage(const Command& command) const;
    void declare(const std::string& name, const std::string& form, const std::string& help,
                 const std::string& group);
    void add_value(const std::string& name, const std::string& value,
                   std::vector<Arguments>& commands) const;

    CLI::App& app_;
    std::vector<RenderStage> stages_;
    CommandTable table_;
    std::map<const CLI::Option*, std::string> names_;
};

/// The command that `--NAME VALUE` stands for. The value has words and key=value options as at the
/// prompt. A file's name is taken as it is. A surface may be written NAME=ISOVALUE[,COLOR].
/// Throws RequestError (usage).
Arguments command_of_option(const Command& command, const std::string& value);

/// Whether the file has a picture for each eye, in one picture (.jps) or in two (.mpo).
bool is_pair_in_one(const std::string& path);
bool is_pair_in_two(const std::string& path);
/// Throws RequestError (usage) if the file has a picture for each eye, but stereo is off.
void check_eyes(std::string_view command, const std::string& path, bool is_stereo);

/// Adds the words KEY=VALUE to the options of a command. Throws RequestError (usage).
void add_key_values(const std::vector<std::string>& words, Arguments& arguments);

/// The request of `render`.
struct RenderRequest {
    std::string volume, output;
    std::vector<std::string> load_words;  ///< KEY=VALUE
    std::vector<Arguments> commands;      ///< The result of CommandOptions::commands().
};

/// The commands of `render`: how pictures look, load, the scene, snapshot, other outputs. All are
/// checked, with the places of their outputs. Throws RequestError.
std::vector<Arguments> render_commands(const RenderRequest& request,
                                       CommandTable table = command_table());

}  // namespace pxpl5::host
