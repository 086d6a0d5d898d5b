#include "host/serve/serve.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "host/base/stopwatch.hpp"
#include "host/machine/machine.hpp"
#include "host/serve/director/director.hpp"
#include "host/serve/director/file_access.hpp"
#include "host/serve/director/inspector.hpp"
#include "host/session/activity_text.hpp"

namespace pxpl5::host::serve {

namespace {

/// Uploads are patients' data: they are removed when the server ends, by Ctrl-C too.
struct RemovedAtEnd {
    std::filesystem::path folder;
    ~RemovedAtEnd() {
        std::error_code ignored;
        std::filesystem::remove_all(folder, ignored);
    }
};

/// Where viewers' commands may read and write.
FileAccess access_of(const ServeOptions& options, const ServerOptions& server) {
    std::vector<std::filesystem::path> others(options.allow.begin(), options.allow.end());
    others.push_back(server.uploads);
    FileAccess access(server.downloads, std::move(others));
    for (const Arguments& command : options.commands) {
        if (command.name == "load" && !command.words.empty()) {
            access.allow_volume(command.words.front());
        }
    }
    return access;
}

/// This computer's name for other computers.
std::string host_name() {
    std::array<char, 256> name{};
    return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "HOST";
}

/// The part of the line for ssh that names this computer.
std::string way_here() {
    const std::string name = host_name();
    // Users of Slurm reach the computer of a job through the one where they have submitted it.
    const char* const login = std::getenv("SLURM_SUBMIT_HOST");
    const bool is_in_job = std::getenv("SLURM_JOB_ID") != nullptr && login != nullptr;
    return is_in_job && name != login ? fmt::format("-J {} {}", login, name) : name;
}

void print_addresses(const Server& server, const ServerOptions& options, const Topology& topology) {
    fmt::print("pxpl5 serves {}\n", size_text(topology));
    fmt::print("open      {}\nto watch  {}\n", server.url(), server.watch_url());
    if (options.bind == ServerOptions{}.bind) {
        fmt::print(
            "from another computer: ssh -L {0}:127.0.0.1:{0} {1}, then open the same address "
            "there\n",
            server.port(), way_here());
    }
    fmt::print("Ctrl-C ends it\n");
    std::fflush(stdout);  // Pipes are not line-buffered.
}

}  // namespace

int serve(const ServeOptions& options) {
    MachineOptions machine_options;
    machine_options.run_base = options.run_base;
    machine_options.keep_runs = options.keep_runs;
    machine_options.io_allow = options.allow;
    machine_options.insecure_tcp = options.insecure_tcp;
    machine_options.io_sandbox = options.io_sandbox;
    auto machine = std::make_shared<Machine>(options.topology, machine_options);
    ServerOptions server_options = options.server;
    server_options.uploads = machine->run_folder() / "uploads";
    server_options.downloads = machine->run_folder() / "downloads";
    const RemovedAtEnd removed{server_options.uploads};
    try {
        Server server(server_options);
        const FileAccess access = access_of(options, server_options);
        WebAudience audience(server);
        DirectorParts parts;
        parts.topology = options.topology.name;
        parts.downloads = server_options.downloads;
        parts.clock_ns = now_ns;
        parts.check_command = [&](const CommandDescriptor& command, const Arguments& arguments) {
            access.check(command, arguments);
        };
        parts.answer = [](Session& session, std::uint32_t id, std::string_view message) {
            return answer_message(id, answer(session, message));
        };
        parts.machine_text = [](Session& session) { return json_text(activity_fields(session)); };
        parts.machine = machine;
        Director director(audience, std::move(parts));
        for (const Arguments& command : options.commands) {
            director.open(to_line(command));
        }
        director.show_first_surfaces();
        print_addresses(server, options.server, options.topology);
        director.run();
    } catch (const MachineError& error) {
        if (!error.is_interruption) {
            throw;
        }
    }
    return 0;
}

}  // namespace pxpl5::host::serve
