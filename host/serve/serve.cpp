#include "host/serve/serve.hpp"

#include <fmt/core.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <optional>
#include <utility>

#include "host/base/kernel/program_folder.hpp"
#include "host/base/kernel/standard_streams.hpp"
#include "host/base/stopwatch.hpp"
#include "host/commands/text/activity_text.hpp"
#include "host/machine/sessions/session_note.hpp"
#include "host/serve/classroom/class_server.hpp"
#include "host/serve/director/director.hpp"
#include "host/serve/director/file_access.hpp"
#include "host/serve/director/folder_list.hpp"
#include "host/serve/director/inspector.hpp"
#include "host/serve/director/scan_questions.hpp"
#include "host/serve/job/job.hpp"
#include "host/serve/limits/memory_limit.hpp"
#include "host/serve/limits/time_limit.hpp"

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
    std::vector<std::filesystem::path> others(options.machine.io_allow.begin(),
                                              options.machine.io_allow.end());
    return FileAccess(server.downloads, std::move(others), {server.uploads});
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

/// The line for ssh that opens the way from another computer; empty if none is needed.
std::string tunnel_to(const Server& server, const ServerOptions& options) {
    return options.bind == ServerOptions{}.bind
               ? fmt::format("ssh -L {0}:127.0.0.1:{0} {1}", server.port(), way_here())
               : "";
}

void print_addresses(const SessionFacts& facts, const Topology& topology) {
    fmt::print("pxpl5 serves {}\n", size_text(topology));
    fmt::print("open      {}\nto watch  {}\n", facts.url, facts.watch_url);
    if (!facts.tunnel.empty()) {
        fmt::print("from another computer: {}, then open the same address there\n", facts.tunnel);
    }
    fmt::print("Ctrl-C ends it\n");
    std::fflush(stdout);  // Pipes are not line-buffered.
}

/// Changes what `pxpl5 sessions` shows.
void change(SessionNote& note, const std::function<void(SessionFacts&)>& act) {
    SessionFacts facts = note.facts();
    act(facts);
    note.set(facts);
}

/// Tells the terminal and other programs of the end that comes, or of no end.
void tell_end_notice(SessionNote& note, const EndNotice& notice) {
    change(note, [&](SessionFacts& facts) {
        facts.ends_at = notice.at;
        facts.saved = notice.saved;
    });
    if (notice.why.empty()) {
        print_notice("note", "the session goes on, because it is used again");
    } else if (!notice.problem.empty()) {
        print_notice("warning", notice.problem);
    } else if (!notice.saved.empty()) {
        print_notice("note", fmt::format("the session is saved in {}. Open it again with: {}",
                                         notice.saved, notice.open));
    } else {
        print_notice("warning", sentence_of(notice));
    }
}

/// The end that --time-limit names, in seconds since 1970.
std::optional<std::int64_t> end_by_user(const std::string& time_limit) {
    return time_limit.empty()
               ? std::nullopt
               : std::optional(std::time(nullptr) + parse_duration("--time-limit", time_limit));
}

/// Returns the parts of the questions about DICOM files. `access` and `server` must outlive the
/// parts.
ScanQuestions::Parts questions_of(const ServeOptions& options, const FileAccess& access,
                                  Server& server) {
    ScanQuestions::Parts parts;
    parts.words = {(program_folder() / "pxpl5-io").string(), "--memory-mib",
                   std::to_string(options.machine.io_memory_mib), "--cpu-s",
                   std::to_string(options.machine.io_cpu_s)};
    for (const std::string& folder : options.machine.io_allow) {
        parts.words.push_back("--allow=" + folder);
    }
    if (!options.machine.io_sandbox) {
        parts.words.emplace_back("--no-sandbox");
    }
    parts.check = [&access](const std::string& path) { access.check_read("ask", path); };
    parts.send = [&server](std::uint32_t viewer, std::string text) {
        server.send(viewer, std::move(text));
    };
    parts.send_binary = [&server](std::uint32_t viewer, std::string bytes) {
        server.send_binary(viewer, std::move(bytes));
    };
    return parts;
}

/// access  Must outlive the parts.
DirectorParts parts_of(const ServeOptions& options, const std::shared_ptr<Machine>& machine,
                       const FileAccess& access, SessionNote& note) {
    DirectorParts parts;
    parts.topology = options.topology.name;
    parts.class_port = options.class_port;
    parts.clock_ns = now_ns;
    parts.check_command = [&access](const CommandDescriptor& command, const Arguments& arguments) {
        access.check(command, arguments);
    };
    parts.answer = [&access](Session& session, std::uint32_t id, std::string_view message) {
        return answer_message(id, asks_for_folder(message)
                                      ? Answer{list_folder(access, message), {}}
                                      : answer(session, message));
    };
    parts.machine_text = [](Session& session) { return json_text(activity_fields(session)); };
    parts.machine = machine;
    // Old run folders are removed, so the session lies beside them.
    const std::filesystem::path& run = machine->run_folder();
    parts.saved_session = run.parent_path() / "saved" / (run.filename().string() + ".pxpl5");
    if (!options.idle_limit.empty()) {
        constexpr double ms_per_s = 1000;
        parts.idle_limit_ms =
            ms_per_s * static_cast<double>(parse_duration("--idle-limit", options.idle_limit));
    }
    parts.tell_end_notice = [&note](const EndNotice& notice) { tell_end_notice(note, notice); };
    parts.tell_restart = [](const std::string& text, bool is_over) {
        print_notice(is_over ? "note" : "warning", text);
    };
    parts.tell_viewers = [&note](std::size_t count) {
        change(note,
               [count](SessionFacts& facts) { facts.viewers = static_cast<std::int64_t>(count); });
    };
    return parts;
}

/// Ends this process with its parent.
void tie_to(pid_t parent) {
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) {  // It has ended before the call.
        throw RequestError(ExitCode::unavailable,
                           fmt::format("process {} has ended, which --end-with names", parent));
    }
}

/// Opens what the command line names, and lets viewers open it again.
void open_content(Director& director, const ServeOptions& options, FileAccess& access) {
    if (!options.session.empty()) {
        director.open_session(options.session);
    }
    for (const Arguments& command :
         options.session.empty() ? options.commands : std::vector<Arguments>{}) {
        director.open(to_line(command));
    }
    if (const auto& load = director.session().history.load_line()) {
        access.allow_volume(parse_line(*load).words.at(0));
    }
    if (options.session.empty()) {
        director.show_first_surfaces();
    }
}

int serve_sessions(const ServeOptions& options) {
    if (is_submitted(options.job, options.topology.cluster)) {
        throw RequestError(ExitCode::usage,
                           "--sessions with --engine slurm needs a job that runs already. Begin "
                           "one with 'salloc', and serve the class in it");
    }
    return serve_class({options.sessions, options.job.words, options.machine.run_base,
                        options.topology.fitted_to_cores, options.idle_limit, options.memory_limit,
                        end_by_user(options.time_limit)},
                       options.server);
}

}  // namespace

int serve(const ServeOptions& options) {
    if (options.end_with != 0) {
        tie_to(options.end_with);
    }
    if (options.sessions > 0) {
        return serve_sessions(options);
    }
    const EndSignal end_signal;  // Before the machine: its threads block the signal, too.
    const std::optional<std::int64_t> user_end_s = end_by_user(options.time_limit);
    if (is_submitted(options.job, options.topology.cluster)) {
        return serve_in_job(options.job, options.machine.run_base, options.time_limit);
    }
    auto machine = std::make_shared<Machine>(options.topology, options.machine);
    ServerOptions server_options = options.server;
    server_options.uploads = machine->run_folder() / "uploads";
    server_options.downloads = machine->run_folder() / "downloads";
    SessionNote note(machine->run_folder());
    const RemovedAtEnd removed{server_options.uploads};
    std::string memory_error;  // Written before the watch is gone, read after that.
    try {
        Server server(server_options);
        const EndWatch end_watch(end_signal, user_end_s,
                                 [&server](EndsSoon soon) { server.warn(std::move(soon)); });
        const MemoryWatch memory_watch(options.memory_limit, [&](const std::string& why) {
            memory_error = why;
            print_error(why, 0);
            server.warn(EndsSoon{std::time(nullptr), why});
            kill(getpid(), SIGTERM);
        });
        FileAccess access = access_of(options, server_options);
        WebAudience audience(server);
        ScanQuestions questions(questions_of(options, access, server));
        DirectorParts parts = parts_of(options, machine, access, note);
        parts.downloads = server_options.downloads;
        parts.answer_later = [&questions](const Session& session, std::uint32_t viewer,
                                          std::uint32_t id, std::string_view message) {
            const bool has_volume = session.volumes.has_volume();
            const Volume none, &open = has_volume ? session.volumes.volume() : none;
            return questions.ask(viewer, id, message, {open.source, open.series});
        };
        Director director(audience, std::move(parts));
        director.session().tell_opened = [&note](const std::string& volume) {
            change(note, [&](SessionFacts& facts) { facts.volume = volume; });
        };
        open_content(director, options, access);
        change(note, [&](SessionFacts& facts) {
            facts.url = server.url();
            facts.watch_url = server.watch_url();
            facts.tunnel = tunnel_to(server, options.server);
        });
        if (options.end_with == 0) {  // The parent shows the addresses.
            print_addresses(note.facts(), options.topology);
        }
        director.run();
        print_notice(
            "note", fmt::format("{} {} without use", idle_end_words,
                                duration_text(parse_duration("--idle-limit", options.idle_limit))));
    } catch (const MachineError& error) {
        if (!error.is_interruption) {
            throw;
        }
    }
    return static_cast<int>(memory_error.empty() ? ExitCode::ok : ExitCode::failed);
}

}  // namespace pxpl5::host::serve
