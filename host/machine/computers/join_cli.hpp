// The command line of `pxpl5 join`.
#pragma once

#include <CLI/CLI.hpp>

#include "host/machine/computers/join.hpp"

namespace pxpl5::host {

/// Adds the subcommand, which fills `options`.
inline void declare_join(CLI::App& parent, JoinOptions& options) {
    CLI::App* app =
        parent.add_subcommand("join", "Let this computer take part in the machine of another one");
    app->add_option("address", options.addresses,
                    "Where the host listens, as it prints it: tcp://10.0.0.1:4711")
        ->required();
    app->add_option("--name", options.name,
                    "Name for the host; the name of this computer by default");
    auto* key = app->add_option_group("key");
    key->add_option("--key-file", options.key_file, "File with the key of the machine, mode 0600");
    key->add_flag("--key-stdin", options.key_from_input,
                  "Read the key from standard input; its end ends this program");
    key->add_option("--munge", options.munge, "Munge credential of the key");
    key->require_option(1);
}

}  // namespace pxpl5::host
