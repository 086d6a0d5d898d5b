// pxpl5: the host program. See README.md for what it can do.
#include <fmt/core.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <functional>
#include <map>

#include "host/base/error.hpp"
#include "host/base/version.hpp"
#include "host/commands/script.hpp"
#include "host/inspect/tools/cli.hpp"
#include "host/machine/machine.hpp"
#include "host/phantom/phantom.hpp"
#include "host/phigs/archive.hpp"
#include "host/report/report.hpp"
#include "host/serve/serve.hpp"

namespace {

using namespace pxpl5::host;

struct MachineFlags {
    std::string topology = "default";
    std::vector<std::string> overrides;
    std::string run_folder = "run", record, vector_target;

    void add_to(CLI::App& app) {
        app.add_option("--topology", topology, "Machine to launch: a name or a file")
            ->capture_default_str();
        app.add_option("--set", overrides, "Change one value of the topology, e.g. gp.count=4")
            ->allow_extra_args(false);
        app.add_option("--record", record, "What nodes keep of their messages, for inspection")
            ->check(CLI::IsMember({"off", "flight", "full"}));
        app.add_option("--vector-target", vector_target,
                       "Vector instructions that nodes compute with; all give the same bits")
            ->check(CLI::IsMember({"best", "sse4", "avx2", "avx512"}));
        add_folder_to(app);
    }
    /// The machine that these flags ask for.
    Topology plan() const {
        Topology plan = load_topology(topology, overrides);
        if (!record.empty()) {
            apply_override(plan, "record=" + record);
        }
        if (!vector_target.empty()) {
            apply_override(plan, "vector_target=" + vector_target);
        }
        return plan;
    }
    void add_folder_to(CLI::App& app) {
        app.add_option("--run-folder", run_folder, "Where the folder of this run is made")
            ->capture_default_str();
    }
    /// Launches the machine, hands it a session, and takes it down again.
    int with_session(const std::function<int(Session&, MachinePort&)>& use) const {
        MachineOptions options;
        options.run_base = run_folder;
        Machine machine(plan(), options);
        Session session(machine);
        const int code = use(session, machine);
        machine.shutdown();
        return code;
    }
};

struct Flags {
    MachineFlags machine;
    bool json = false, dry_run = false, keep_going = false;
    std::string script, volume, view, size, output;
    std::vector<std::string> commands, surfaces, load_words;
    std::optional<double> isovalue;
    int samples = 1;
    serve::ServerOptions server;
    report::ReportOptions report;
};

Arguments command(std::string name, std::vector<std::string> words,
                  std::map<std::string, std::string> options = {}) {
    return {std::move(name), std::move(words), std::move(options)};
}

LineSource lines_of_commands(std::vector<Arguments> commands) {
    return [commands = std::move(commands), at = std::size_t{0}]() mutable {
        return at < commands.size() ? std::optional(to_line(commands[at++])) : std::nullopt;
    };
}

/// "name[=isovalue[,colour]]" of --surface.
Arguments surface_command(const std::string& text) {
    const std::size_t equals = text.find('='), comma = text.find(',');
    if (equals == std::string::npos && comma == std::string::npos) {
        return command("surface", {text});  // A tissue of CT, or as a built-in volume suggests.
    }
    if (equals == std::string::npos || equals == 0) {
        throw RequestError(
            ExitCode::usage,
            fmt::format("--surface '{}' is not of the form name[=isovalue[,colour]]", text));
    }
    Arguments surface = command("surface", {text.substr(0, equals)});
    surface.options["iso"] = text.substr(equals + 1, comma - equals - 1);
    if (comma != std::string::npos) {
        surface.options["color"] = text.substr(comma + 1);
    }
    return surface;
}

/// load or info with the key=value words of the command line.
Arguments volume_command(const std::string& name, const Flags& flags) {
    Arguments volume = command(name, {flags.volume});
    for (const std::string& word : flags.load_words) {
        const std::size_t equals = word.find('=');
        if (equals == std::string::npos || equals == 0) {
            throw RequestError(ExitCode::usage,
                               fmt::format("'{}' is not of the form KEY=VALUE, as series=2", word));
        }
        volume.options[word.substr(0, equals)] = word.substr(equals + 1);
    }
    return volume;
}

/// `render` is nothing but these commands.
std::vector<Arguments> render_commands(const Flags& flags) {
    std::vector<Arguments> commands;
    if (!flags.size.empty()) {
        commands.push_back(command("size", {flags.size}));
    }
    if (flags.samples != 1) {
        commands.push_back(command("antialias", {fmt::format("{}", flags.samples)}));
    }
    if (!flags.view.empty()) {
        commands.push_back(parse_line("view " + flags.view));
    }
    commands.push_back(volume_command("load", flags));
    if (flags.isovalue) {
        commands.push_back(
            command("surface", {"surface"}, {{"iso", fmt::format("{}", *flags.isovalue)}}));
    }
    const std::vector<PhantomSurface> suggested = suggested_surfaces(flags.volume);
    if (!flags.isovalue && flags.surfaces.empty() && !suggested.empty()) {
        commands.push_back(command("surface", {suggested.front().name}));
    }
    for (const std::string& surface : flags.surfaces) {
        commands.push_back(surface_command(surface));
    }
    commands.push_back(command("snapshot", {flags.output}));
    return commands;
}

int run(const Flags& flags) {
    if (flags.dry_run) {
        fmt::print("{}", resolved_json(flags.machine.plan()));
        return 0;
    }
    return flags.machine.with_session([&](Session& session, MachinePort& machine) {
        ScriptOptions options{.json = flags.json, .keep_going = flags.keep_going};
        if (!flags.commands.empty()) {
            std::string text;
            for (const std::string& command : flags.commands) {
                text += command + "\n";
            }
            return run_script(session, lines_of_text(text), options);
        }
        if (!flags.script.empty() && flags.script != "-") {
            options.echo = true;
            return run_script(session, lines_of_file(flags.script, machine), options);
        }
        if (isatty(STDIN_FILENO) != 0) {
            options.keep_going = true;
            fmt::print("pxpl5 {}: {}; 'help' lists the commands\n", version,
                       size_text(flags.machine.plan()));
            run_script(session, lines_of_prompt(machine), options);
            return 0;
        }
        return run_script(session, lines_of(STDIN_FILENO, machine), options);
    });
}

int render(const Flags& flags) {
    if (!flags.isovalue && flags.surfaces.empty() && !is_phantom(flags.volume) &&
        !phigs::is_archive(flags.volume)) {
        throw RequestError(ExitCode::usage,
                           fmt::format("render needs --iso V or --surface name=V; 'pxpl5 info {}' "
                                       "tells which values the volume has",
                                       flags.volume));
    }
    const std::vector<Arguments> commands = render_commands(flags);
    return flags.machine.with_session([&](Session& session, MachinePort&) {
        session.will_write = true;
        return run_script(session, lines_of_commands(commands), {.json = flags.json});
    });
}

/// Reading needs no more machine than the smallest.
int info(Flags flags) {
    flags.machine.topology = "one-of-each";
    flags.machine.record = "off";
    return flags.machine.with_session([&](Session& session, MachinePort&) {
        return run_script(session, lines_of_commands({volume_command("info", flags)}),
                          {.json = flags.json});
    });
}

int serve_viewer(const Flags& flags) {
    serve::ServeOptions options;
    options.server = flags.server;
    options.topology = flags.machine.plan();
    options.run_base = flags.machine.run_folder;
    Flags opened = flags;
    opened.volume = flags.volume.empty() ? "phantom:pelvis" : flags.volume;
    options.commands.push_back(volume_command("load", opened));
    for (const std::string& surface : flags.surfaces) {
        options.commands.push_back(surface_command(surface));
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
        session.will_write = !flags.report.pictures.empty();
        report::run_report(session, flags.report, modelled, size_text(draws.plan()));
        return 0;
    });
}

CLI::App* declare_report(CLI::App& parent, report::ReportOptions& options) {
    CLI::App* app = parent.add_subcommand(
        "report",
        "The paper's results, modelled and measured; --topology and --set say what is "
        "modelled (paper-1993 if not given)");
    app->add_flag("--paper", options.paper, "The paper's results table, run again");
    app->add_flag("--scaling", options.scaling, "Modelled speed-up with 1 to 64 GPs and Renderers");
    app->add_option("rows", options.rows, "Only these: pelvis/skin, pelvis/muscle, ...");
    app->add_option("--data", options.data, "Folder of real volumes with the paper's loads");
    app->add_flag("--sensitivity", options.sensitivity,
                  "How modelled figures change with each parameter");
    app->add_flag("--fit", options.fit, "Fit the parameters that are fitted once more");
    app->add_flag("--json", options.json, "One JSON object instead of text");
    app->add_option("--csv", options.csv,
                    "Table to write; of the sensitivity, if that is asked for");
    app->add_option("--picture", options.picture,
                    "Writes the plot (.svg, .png or .pdf); with --sensitivity, its plot");
    app->add_option("--pictures", options.pictures, "Folder for pictures of the surfaces");
    return app;
}

/// Declares the subcommands. Exactly one of them, or none, is then parsed.
void declare(CLI::App& app, Flags& flags) {
    app.set_version_flag("--version", std::string(version_line()));
    CLI::App* run_app = app.add_subcommand("run", "Run a script, commands, or a prompt");
    run_app->add_option("script", flags.script, "Script file; - is standard input");
    run_app->add_option("-c,--command", flags.commands, "Commands, separated by ';'");
    run_app->add_flag("--keep-going", flags.keep_going, "Go on after a command that failed");
    run_app->add_flag("--dry-run", flags.dry_run, "Print the resolved topology and stop");

    CLI::App* render_app = app.add_subcommand("render", "Draw surfaces of a volume into a picture");
    render_app->add_option("volume", flags.volume, "File, DICOM folder or phantom:NAME")
        ->required();
    render_app->add_option("--iso", flags.isovalue, "Isovalue of the surface");
    render_app->add_option("--surface", flags.surfaces,
                           "Several surfaces: name[=isovalue[,colour]]");
    render_app->add_option("--view", flags.view, "Named view, or \"AZ EL [zoom=Z]\"");
    render_app->add_option("--antialias", flags.samples, "Samples a pixel: 1, 4 or 16")
        ->check(CLI::IsMember({1, 4, 16}));
    render_app->add_option("--size", flags.size,
                           "WIDTHxHEIGHT of the picture, 512x512 if not given");
    render_app->add_option("-o,--output", flags.output, "Picture to write")->required();

    CLI::App* serve_app = app.add_subcommand("serve", "Show a volume in the browser");
    serve_app->add_option("volume", flags.volume,
                          "File, DICOM folder or phantom:NAME; phantom:pelvis if not given");
    serve_app->add_option("--surface", flags.surfaces,
                          "Surfaces to begin with: name[=isovalue[,colour]]");
    serve_app->add_option("--port", flags.server.port, "Port; 0 is a free one")
        ->check(CLI::Range(0, 65535));
    serve_app->add_option("--bind", flags.server.bind, "Address to listen at")
        ->capture_default_str();
    serve_app->add_option("--tls-cert", flags.server.tls_cert, "Certificate (PEM)");
    serve_app->add_option("--tls-key", flags.server.tls_key, "Its key (PEM)");
    serve_app->add_flag("--insecure", flags.server.insecure,
                        "Listen beyond this computer without encryption");

    CLI::App* info_app = app.add_subcommand("info", "Tell what is known of a volume");
    info_app->add_option("volume", flags.volume, "File, DICOM folder or phantom:NAME")->required();

    for (CLI::App* each : {render_app, info_app, serve_app}) {
        each->add_option("options", flags.load_words,
                         "KEY=VALUE as of the command load: series=2, spacing=1,1,2, crop=...");
    }
    flags.machine.add_folder_to(*info_app);

    CLI::App* report_app = declare_report(app, flags.report);

    for (CLI::App* each : {run_app, render_app, report_app, serve_app}) {
        flags.machine.add_to(*each);
    }
    for (CLI::App* each : {run_app, render_app, info_app}) {
        each->add_flag("--json", flags.json, "One JSON object per command and line");
    }
    app.require_subcommand(0, 1);
}

int dispatch(const CLI::App& app, const Flags& flags) {
    if (app.got_subcommand("render")) {
        return render(flags);
    }
    if (app.got_subcommand("info")) {
        return info(flags);
    }
    if (app.got_subcommand("serve")) {
        return serve_viewer(flags);
    }
    if (app.got_subcommand("report")) {
        return run_report(flags, app.get_subcommand("report")->count("--topology") > 0);
    }
    return run(flags);
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("pxpl5: surfaces of medical volumes, drawn by a working Pixel-Planes 5");
    Flags flags;
    declare(app, flags);
    const std::function<std::optional<int>()> run_inspection = inspect::declare_inspection(app);
    if (argc < 2 || std::string_view(argv[1]) == "help") {
        fmt::print("{}", app.help());
        return 0;
    }
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : static_cast<int>(ExitCode::usage);
    }
    try {
        const std::optional<int> inspected = run_inspection();
        return inspected ? *inspected : dispatch(app, flags);
    } catch (const RequestError& error) {
        fmt::print(stderr, "error: {}\n", error.what());
        return static_cast<int>(error.code);
    } catch (const MachineError& error) {
        fmt::print(stderr, "error: {}\n", error.what());
        return error.code;
    } catch (const std::exception& error) {
        fmt::print(stderr, "error: {}\n", error.what());
        return static_cast<int>(ExitCode::failed);
    }
}
