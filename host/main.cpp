// pxpl5: the host program. See README.md for what it can do.
#include <fmt/core.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <memory>

#include "host/base/error.hpp"
#include "host/base/kernel/standard_streams.hpp"
#include "host/base/state_folder.hpp"
#include "host/base/version.hpp"
#include "host/commands/cli_errors.hpp"
#include "host/commands/command_options.hpp"
#include "host/commands/script.hpp"
#include "host/inspect/tools/cli.hpp"
#include "host/machine/computers/join/join_cli.hpp"
#include "host/machine/computers/plan_text.hpp"
#include "host/machine/machine.hpp"
#include "host/machine/sessions/session_note.hpp"
#include "host/machine/sessions/sessions_cli.hpp"
#include "host/report/report_cli.hpp"
#include "host/serve/serve.hpp"
#include "host/serve/serve_cli.hpp"
#include "ringbus/process/kept_memory.hpp"

namespace {

using namespace pxpl5;
using namespace pxpl5::host;

struct MachineFlags {
    std::string topology = "default";
    std::vector<std::string> overrides, allow;
    std::optional<int> keep_runs;
    std::string run_folder = default_run_base().string(), record, vector_target;
    bool insecure_tcp = false, no_io_sandbox = false;
    ClusterFlags cluster;

    void add_to(CLI::App& app) {
        app.add_option("--topology", topology, "Machine to launch: a name or a file")
            ->capture_default_str();
        app.add_option("--set", overrides,
                       "Change one value of the topology, for example gp.count=4")
            ->allow_extra_args(false);
        app.add_option("--record", record, "Trace recording: none, recent seconds, or everything")
            ->check(is_named<Recording>());
        app.add_option("--vector-target", vector_target,
                       "Vector instructions of the nodes; all give the same bits")
            ->check(is_named<VectorTarget>());
        cluster.add_to(app);
        app.add_flag("--insecure-tcp", insecure_tcp,
                     "Let ring.transport=tcp work without encryption");
        add_folder_to(app);
        app.add_option(
               "--keep-runs", keep_runs,
               "Keep the newest N run folders, 0: all; 20 by default, with --run-folder all")
            ->check(CLI::Range(0, 1'000'000));
    }
    bool has_default_folder() const { return run_folder == default_run_base(); }
    int runs_kept() const { return keep_runs.value_or(has_default_folder() ? 20 : 0); }
    /// The machine that these flags ask for.
    Topology plan() const {
        Topology plan = load_topology(topology, cluster.added_to(overrides));
        plan.cluster.key_file = cluster.key_file;
        if (!record.empty()) {
            apply_override(plan, "record=" + record);
        }
        if (!vector_target.empty()) {
            apply_override(plan, "vector_target=" + vector_target);
        }
        return plan;
    }
    void add_folder_to(CLI::App& app) {
        app.add_option("--run-folder", run_folder,
                       "Parent directory for run folders; $XDG_STATE_HOME/pxpl5 by default");
    }
    void add_file_options_to(CLI::App& app) {
        app.add_flag("--no-io-sandbox", no_io_sandbox,
                     "Read and write files without the sandbox of pxpl5-io, for debugging");
        app.add_option("--allow", allow,
                       "Also read files in this folder that the header of a volume or a link in a "
                       "DICOM folder names; by default they must lie in the folder of the volume")
            ->allow_extra_args(false)
            ->type_name("DIR")
            ->check(CLI::ExistingDirectory);
    }
    MachineOptions options() const {
        MachineOptions options;
        options.run_base = run_folder;
        options.keep_runs = runs_kept();
        options.io_allow = allow;
        options.insecure_tcp = insecure_tcp;
        options.io_sandbox = !no_io_sandbox;
        return options;
    }
    /// Launches the machine, hands it a session, and takes it down again.
    int with_session(const std::function<int(Session&, MachinePort&)>& use) const {
        Machine machine(plan(), options());
        SessionNote note(machine.run_folder());
        Session session(machine);
        session.tell_opened = [&note](const std::string& volume) { note.set({volume}); };
        const int code = use(session, machine);
        machine.shutdown();
        return code;
    }
};

struct Flags {
    MachineFlags machine;
    bool json = false, dry_run = false, keep_going = false, strict = false;
    std::string script, volume, output;
    std::vector<std::string> commands, surfaces, load_words;
    JoinOptions join;
    std::shared_ptr<const CommandOptions> render_options, info_options, serve_options;
    serve::ServeOptions serve;
    report::ReportOptions report;
};

LineSource lines_of_commands(std::vector<Arguments> commands) {
    return [commands = std::move(commands), at = std::size_t{0}]() mutable {
        return at < commands.size() ? std::optional(to_line(commands[at++])) : std::nullopt;
    };
}

/// `load` or `info` with the options of the command line.
Arguments volume_command(const std::string& name, const Flags& flags,
                         const std::vector<Arguments>& named) {
    Arguments volume{name, {flags.volume}, {}};
    for (const Arguments& each : named) {
        if (each.name == "load") {
            volume.options = each.options;
        }
    }
    add_key_values(flags.load_words, volume);
    return volume;
}

std::string joined_lines(const std::vector<std::string>& commands) {
    std::string text;
    for (const std::string& command : commands) {
        text += command + "\n";
    }
    return text;
}

/// True if no command needs a machine.
bool asks_for_help_only(const std::string& text) {
    bool has_help = false;
    const LineSource next = lines_of_text(text);
    for (std::optional<std::string> line; (line = next());) {
        const std::string name = parse_line(*line).name;
        if (!name.empty() && name != "help" && name != "quit") {
            return false;
        }
        has_help |= name == "help";
    }
    return has_help;
}

int print_help(const std::string& text, bool json) {
    const LineSource next = lines_of_text(text);
    for (std::optional<std::string> line; (line = next());) {
        const Arguments arguments = parse_line(*line);
        if (is_quit(arguments)) {
            break;
        }
        if (!arguments.name.empty()) {
            check_arguments(find_command(arguments.name), arguments);
            const Reply reply = help_reply(command_table(), arguments);
            fmt::print("{}\n",
                       json ? json_line({to_line(arguments), "help", 0}, reply) : reply.text);
        }
    }
    return 0;
}

/// Prints the usage of the program, of a subcommand, or the help of a command of the prompt. Throws
/// RequestError (usage) with the nearest name if there is no such subcommand or command.
int print_usage(const CLI::App& app, const std::vector<std::string>& words) {
    const auto told = app.get_subcommands(
        [&](const CLI::App* each) { return !words.empty() && each->check_name(words.front()); });
    if (!words.empty() && told.empty()) {
        return print_help("help " + words.front(), false);
    }
    fmt::print("{}", told.empty() ? app.help() : told.front()->help());
    return 0;
}

ScriptOptions script_options(const Flags& flags) {
    return {.json = flags.json, .keep_going = flags.keep_going, .strict = flags.strict};
}

int run_prompt(const Flags& flags, Session& session, MachinePort& machine) {
    ScriptOptions options = script_options(flags);
    options.keep_going = true;
    options.is_prompt = true;
    fmt::print("pxpl5 {}: {}; 'help' lists the commands\n", version,
               size_text(flags.machine.plan()));
    run_script(session, lines_of_prompt(machine), options);
    return 0;
}

int run(const Flags& flags) {
    if (flags.dry_run) {
        const Topology plan = flags.machine.plan();
        fmt::print("{}", resolved_json(plan));
        fmt::print(stderr, "{}", plan_text(plan));  // The file stays a topology.
        return 0;
    }
    if (!flags.script.empty() && !flags.commands.empty()) {
        refuse_command(fmt::format("run: unexpected argument '{}': give a script or -c, not both",
                                   flags.script));
    }
    const std::string text = joined_lines(flags.commands);
    if (asks_for_help_only(text)) {
        return print_help(text, flags.json);
    }
    return flags.machine.with_session([&](Session& session, MachinePort& machine) {
        ScriptOptions options = script_options(flags);
        if (!flags.commands.empty()) {
            return run_script(session, lines_of_text(text), options);
        }
        if (!flags.script.empty() && flags.script != "-") {
            options.echo = true;
            return run_script(session, lines_of_file(flags.script, machine), options);
        }
        return isatty(STDIN_FILENO) != 0
                   ? run_prompt(flags, session, machine)
                   : run_script(session, lines_of(STDIN_FILENO, machine), options);
    });
}

int render(const Flags& flags) {
    const std::vector<Arguments> commands = render_commands(
        {flags.volume, flags.output, flags.load_words, flags.render_options->commands()});
    return flags.machine.with_session([&](Session& session, MachinePort&) {
        session.load_settings.will_write = true;
        return run_script(session, lines_of_commands(commands), script_options(flags));
    });
}

/// Prints a volume. The machine is the smallest, and its run folder is removed again unless the
/// user has named a place for it.
int info(Flags flags) {
    const Arguments command = volume_command("info", flags, flags.info_options->commands());
    check_arguments(find_command("info"), command);
    flags.machine.topology = "one-of-each";
    flags.machine.record = "off";
    std::optional<TemporaryFolder> folder;
    if (flags.machine.has_default_folder()) {
        flags.machine.run_folder = folder.emplace(info_folder).path().string();
    }
    return flags.machine.with_session([&](Session& session, MachinePort&) {
        return run_script(session, lines_of_commands({command}), script_options(flags));
    });
}

int serve_viewer(const Flags& flags) {
    serve::ServeOptions options = flags.serve;
    options.topology = flags.machine.plan();
    options.machine = flags.machine.options();
    Flags opened = flags;
    opened.volume = flags.volume.empty() ? "phantom:pelvis" : flags.volume;
    options.commands.push_back(volume_command("load", opened, flags.serve_options->commands()));
    for (const std::string& surface : flags.surfaces) {
        options.commands.push_back(command_of_option(find_command("surface"), surface));
    }
    return serve::serve(options);
}

/// --topology and --set are of the modelled machine; the default one draws.
int run_report(const Flags& flags, bool has_topology) {
    const Topology modelled = load_topology(has_topology ? flags.machine.topology : "paper-1993",
                                            flags.machine.overrides);
    report::check(flags.report);
    MachineFlags draws = flags.machine;
    draws.topology = MachineFlags().topology;
    draws.overrides.clear();
    return draws.with_session([&](Session& session, MachinePort&) {
        session.load_settings.will_write = !flags.report.pictures.empty();
        report::run_report(session, flags.report, modelled, size_text(draws.plan()));
        return 0;
    });
}

CLI::App* declare_run(CLI::App& parent, Flags& flags) {
    CLI::App* app = parent.add_subcommand("run", "Run a script, commands, or a prompt");
    app->add_option("script", flags.script, "Script file; - is standard input");
    app->add_option("-c,--command", flags.commands, "Commands, separated by ';'")
        ->allow_extra_args(false);
    app->add_flag("--keep-going", flags.keep_going, "Continue after a command that failed");
    app->add_flag("--dry-run", flags.dry_run,
                  "Print the resolved topology and the nodes of each computer");
    return app;
}

CLI::App* declare_render(CLI::App& parent, Flags& flags) {
    CLI::App* app = parent.add_subcommand("render", "Draw surfaces of a volume into a picture");
    app->add_option("volume", flags.volume, "File, DICOM folder or phantom:NAME")->required();
    app->add_option("-o,--output", flags.output, "Picture to write")->required();
    using enum RenderStage;
    flags.render_options =
        std::make_shared<CommandOptions>(*app, std::vector<RenderStage>{look, load, scene, output});
    return app;
}

CLI::App* declare_serve(CLI::App& parent, Flags& flags) {
    CLI::App* app = parent.add_subcommand("serve", "Show a volume in the browser");
    app->add_option("volume", flags.volume,
                    "File, DICOM folder or phantom:NAME; phantom:pelvis by default");
    app->add_option("--surface", flags.surfaces, "First surfaces: NAME[=ISOVALUE[,COLOR]]")
        ->allow_extra_args(false);
    serve::declare_server(*app, flags.serve);
    flags.serve_options = std::make_shared<CommandOptions>(*app, std::vector{RenderStage::load});
    return app;
}

/// Declares the subcommands. Exactly one of them, or none, is then parsed.
void declare(CLI::App& app, Flags& flags) {
    app.set_version_flag("--version", std::string(version_line()));
    CLI::App* run_app = declare_run(app, flags);
    CLI::App* render_app = declare_render(app, flags);
    CLI::App* serve_app = declare_serve(app, flags);
    CLI::App* info_app =
        app.add_subcommand("info", "Print a volume's geometry, values and warnings");
    info_app->add_option("volume", flags.volume, "File, DICOM folder or phantom:NAME")->required();
    flags.info_options =
        std::make_shared<CommandOptions>(*info_app, std::vector{RenderStage::load});
    for (CLI::App* each : {render_app, info_app, serve_app}) {
        each->add_option("options", flags.load_words,
                         "KEY=VALUE as in the command load: series=2, spacing=1,1,2, crop=...");
    }
    flags.machine.add_folder_to(*info_app);
    declare_join(app, flags.join);
    CLI::App* report_app = report::declare_report(app, flags.report);
    for (CLI::App* each : {run_app, render_app, report_app, serve_app}) {
        flags.machine.add_to(*each);
    }
    for (CLI::App* each : {run_app, render_app, info_app, serve_app}) {
        flags.machine.add_file_options_to(*each);
    }
    for (CLI::App* each : {run_app, render_app, info_app}) {
        each->add_flag("--json", flags.json, "Print one JSON object per command and line");
        each->add_flag("--strict", flags.strict, "Fail with exit code 3 if a command warns");
    }
    app.require_subcommand(0, 1);
}

int dispatch(const CLI::App& app, const Flags& flags) {
    if (const std::optional<int> code = run_join(app, flags.join)) {
        return *code;
    }
    if (app.got_subcommand("render")) {
        return render(flags);
    }
    if (app.got_subcommand("serve")) {
        return serve_viewer(flags);
    }
    if (app.got_subcommand("report")) {
        return run_report(flags, app.get_subcommand("report")->count("--topology") > 0);
    }
    return app.got_subcommand("info") ? info(flags) : run(flags);
}

}  // namespace

int main(int argc, char** argv) {
    bus::keep_freed_memory(32 << 20, 64 << 20);
    open_missing_streams();
    CLI::App app("Surfaces of medical volumes, drawn by a working Pixel-Planes 5", "pxpl5");
    Flags flags;
    declare(app, flags);
    flags.serve.job.words.assign(argv + std::min(argc, 2), argv + argc);
    const std::function<std::optional<int>()> run_sessions = declare_sessions(app);
    const std::function<std::optional<int>()> run_inspection = inspect::declare_inspection(app);
    const bool wants_usage = argc < 2 || std::string_view(argv[1]) == "help";
    try {
        if (!wants_usage) {
            app.parse(argc, argv);
        }
    } catch (const CLI::ParseError& error) {
        return finish_output(report_parse_error(app, error));
    }
    try {
        if (wants_usage) {
            return finish_output(print_usage(app, {argv + std::min(argc, 2), argv + argc}));
        }
        std::optional<int> done = run_sessions();
        done = done ? done : run_inspection();
        return finish_output(done ? *done : dispatch(app, flags));
    } catch (const RequestError& error) {
        return print_error(error.what(), static_cast<int>(error.code));
    } catch (const MachineError& error) {
        return print_error(error.what(), error.code);
    } catch (const std::exception& error) {
        return print_error(error.what(), static_cast<int>(ExitCode::failed));
    }
}
