// The command lines of `pxpl5 join` and `pxpl5 key`, and the options of a machine that others join.
#pragma once

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/machine/computers/join/join.hpp"
#include "host/machine/computers/join/key.hpp"
#include "host/machine/topology.hpp"

namespace pxpl5::host {

/// Adds the subcommand, which fills `options`.
inline void declare_join(CLI::App& parent, JoinOptions& options) {
    CLI::App* app =
        parent.add_subcommand("join", "Let this computer take part in the machine of another one");
    app->add_option("address", options.addresses,
                    "Where the host listens, as it prints it: tcp://10.0.0.1:4711; a name for "
                    "the address is looked up")
        ->required();
    app->add_option("--name", options.name,
                    "Name for the host; the name of this computer by default");
    auto* key = app->add_option_group("key");
    key->add_option("--key-file", options.key_file, "File with the key of the machine, mode 0600");
    key->add_flag("--key-stdin", options.key_from_input,
                  "Read the key from standard input; its end ends this program");
    key->add_option("--munge", options.munge, "Munge credential of the key");
    key->require_option(1);
    constexpr int day_s = 86'400;
    app->add_option("--wait", options.wait_s, "Seconds to wait for the host to start")
        ->check(CLI::Range(1, day_s))
        ->capture_default_str();
    app->add_flag("--again", options.again,
                  "When the machine has ended, wait for the next one and join it");
    parent.add_subcommand("key", "Print a new key for --key-file");
}

/// Runs `pxpl5 join` or `pxpl5 key`. Returns nothing if `app` got another subcommand.
inline std::optional<int> run_join(const CLI::App& app, const JoinOptions& options) {
    if (app.got_subcommand("key")) {
        fmt::print("{}", key_text(make_key()));
        return 0;
    }
    return app.got_subcommand("join") ? std::optional(join_machine(options)) : std::nullopt;
}

/// Accepts the names of an enum.
template <class Enum>
CLI::IsMember is_named() {
    return CLI::IsMember(
        std::vector<std::string>(enum_names<Enum>.begin(), enum_names<Enum>.end()));
}

/// Options for the computers of a machine.
struct ClusterFlags {
    std::string engine, computers, listen, key_file;

    void add_to(CLI::App& app) {
        app.add_option("--engine", engine, "What starts nodes on other computers")
            ->check(is_named<Engine>());
        app.add_option("--computers", computers,
                       "The other computers: n1,n2 or with the nodes that each takes, n1:8,n2:16");
        app.add_option("--listen", listen,
                       "Address, with or without the port, where computers join: 10.0.0.1:5755");
        app.add_option("--key-file", key_file,
                       "File with the key of the machine, from pxpl5 key; for --engine wait");
    }
    /// `changes` of a topology and those of these flags.
    std::vector<std::string> added_to(std::vector<std::string> changes) const {
        for (const auto& [key, value] :
             {std::pair{"computers=", computers}, {"engine=", engine}, {"listen=", listen}}) {
            if (!value.empty()) {
                changes.push_back(key + value);
            }
        }
        return changes;
    }
};

}  // namespace pxpl5::host
