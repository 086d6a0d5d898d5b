#include "host/commands/script.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/kernel/standard_streams.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/text/progress_bar.hpp"

namespace pxpl5::host {

namespace {

constexpr std::size_t chunk_bytes = 4096;

/// Serves `machine` while no input is readable.
WaitReadable waiting_in(MachinePort& machine) {
    return [&machine](int fd) { machine.wait_readable(fd); };
}

/// Cuts what a descriptor yields into lines.
class LineReader {
  public:
    LineReader(int fd, std::string name, MachinePort& machine)
        : fd_(fd), name_(std::move(name)), wait_(waiting_in(machine)) {}

    std::optional<std::string> next() {
        for (std::size_t searched = 0;;) {
            if (const std::size_t end = text_.find('\n', searched); end != std::string::npos) {
                std::string line = text_.substr(0, end);
                text_.erase(0, end + 1);
                return line;
            }
            if (text_.size() > max_line_bytes) {
                throw RequestError(ExitCode::usage, fmt::format("{}: a line has more than {} bytes",
                                                                name_, max_line_bytes));
            }
            searched = text_.size();
            std::array<char, chunk_bytes> chunk;
            const std::size_t count = read_some(fd_, wait_, chunk, name_);
            if (count == 0) {
                return text_.empty() ? std::nullopt : std::optional(std::exchange(text_, {}));
            }
            text_.append(chunk.data(), count);
        }
    }

  private:
    int fd_;
    std::string name_;
    WaitReadable wait_;
    std::string text_;  ///< Read, but not handed out.
};

/// Standard output is full or closed.
struct OutputLost : RequestError {
    using RequestError::RequestError;
};

/// Prints one outcome at once, so that the reader of a pipe sees progress. After the reader of the
/// pipe has closed it (| head), prints nothing: the commands still write their files.
/// Throws OutputLost (failed) if standard output cannot be written for another reason.
class Output {
  public:
    void print(const std::string& text) {
        if (text.empty() || is_closed_) {
            return;
        }
        const std::string line = text + '\n';
        std::fwrite(line.data(), 1, line.size(), stdout);
        if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) {
            return;
        }
        if (errno != EPIPE) {
            throw OutputLost(ExitCode::failed, fmt::format("standard output cannot be written: {}",
                                                           std::strerror(errno)));
        }
        is_closed_ = true;
    }

  private:
    bool is_closed_ = false;
};

/// The line without blanks at its ends.
std::string trimmed(const std::string& line) {
    const std::size_t first = line.find_first_not_of(" \t\r");
    return first == std::string::npos
               ? ""
               : line.substr(first, line.find_last_not_of(" \t\r") - first + 1);
}

double ms_now() {
    return std::chrono::duration<double, std::milli>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

/// A command at a prompt: while it exists, Ctrl-C cancels the command, and a bar shows how far it
/// is.
class PromptCommand {
  public:
    explicit PromptCommand(Session& session)
        : machine_(session.conversation.machine()), bar_(session) {
        machine_.cancel_on_interrupt(true);
    }
    ~PromptCommand() { machine_.cancel_on_interrupt(false); }
    PromptCommand(const PromptCommand&) = delete;
    PromptCommand& operator=(const PromptCommand&) = delete;

  private:
    MachinePort& machine_;
    ProgressBar bar_;
};

constexpr int interrupted_code = 128 + SIGINT;  // The code that shells give.

/// Runs the lines of one script.
class Script {
  public:
    Script(Session& session, const ScriptOptions& options) : session_(session), options_(options) {
        session.recovery.on_restart([](const std::string& text, bool is_over) {
            print_notice(is_over ? "note" : "warning", text);
        });
    }
    ~Script() { session_.recovery.on_restart({}); }
    Script(const Script&) = delete;
    Script& operator=(const Script&) = delete;

    /// Runs a line. At a prompt, ';' separates several commands: the others are left out after one
    /// that fails or is canceled. Returns false if the script ends with this line.
    bool run_line(const std::string& line) {
        if (!options_.is_prompt) {
            return run(line);
        }
        const LineSource next_command = lines_of_text(line);
        has_failed_ = false;
        for (std::optional<std::string> command; !has_failed_ && (command = next_command());) {
            if (!run(*command)) {
                return false;
            }
        }
        return true;
    }
    /// Returns false if the script ends with this command.
    bool run(const std::string& line) {
        start_ms_ = ms_now();
        outcome_ = {trimmed(line), "", 0, {}};
        try {
            const Arguments arguments = parse_line(line);
            outcome_.name = arguments.name;
            return arguments.name.empty() || (!is_quit(arguments) && run(arguments));
        } catch (const OutputLost&) {
            throw;  // No later answer can be written either.
        } catch (const Canceled& canceled) {
            if (options_.is_prompt) {
                return fail(canceled.what(), canceled.code, nullptr);
            }
            fail("interrupted by SIGINT", static_cast<ExitCode>(interrupted_code), nullptr);
            exit_code_ = interrupted_code;
            return false;
        } catch (const RequestError& error) {
            return fail(error.what(), error.code, nullptr);
        } catch (const MachineError& death) {
            tell_end(death);
            throw;
        }
    }
    /// Prints the object of the command under which the machine has ended. Otherwise a program
    /// that waits for the answer would not learn of the error.
    void tell_end(const MachineError& death) {
        if (options_.json) {
            close_outcome();
            output_.print(json_error_line(outcome_, death.what(), death.code));
        }
    }
    /// The same if the machine ends before the next command is known: its object has no command.
    void tell_end_between(const MachineError& death) {
        if (!death.is_interruption) {
            outcome_ = {};
            start_ms_ = ms_now();
            tell_end(death);
        }
    }
    /// Tells of content that was lost between two commands. The object of the next command names
    /// the restart; if the script ends, the loss has an object of its own. Returns false then.
    bool tell_loss(const ContentLost& loss) {
        if (options_.json && options_.keep_going) {
            exit_code_ = exit_code_ == 0 ? static_cast<int>(loss.code) : exit_code_;
            return true;
        }
        outcome_ = {};
        start_ms_ = ms_now();
        return fail(loss.what(), loss.code, nullptr);
    }
    int exit_code() const { return exit_code_; }

  private:
    /// Adds the time, and the restarts since the last outcome.
    void close_outcome() {
        outcome_.elapsed_ms = ms_now() - start_ms_;
        for (const Restart& restart : session_.recovery.take_restarts()) {
            outcome_.restarts.push_back({{"node", restart.node},
                                         {"cause", restart.cause},
                                         {"gps", std::int64_t{restart.gps}},
                                         {"renderers", std::int64_t{restart.renderers}},
                                         {"restored", restart.is_restored},
                                         {"ms", restart.ms}});
        }
    }

    bool run(const Arguments& arguments) {
        if (options_.echo && !options_.json) {
            output_.print("> " + printable(outcome_.command));
        }
        const Reply reply = [&] {
            std::optional<PromptCommand> at_prompt;
            if (options_.is_prompt) {
                at_prompt.emplace(session_);
            }
            return run_command(session_, arguments, nullptr, options_.table);
        }();
        const bool fails = options_.strict && !reply.warnings.empty();
        close_outcome();
        if (!options_.json || !fails) {
            output_.print(options_.json ? json_line(outcome_, reply) : printable(reply.text));
        }
        return !fails || fail("--strict: " + reply.warnings.front(), ExitCode::warning, &reply);
    }

    bool fail(const std::string& error, ExitCode exit_code, const Reply* reply) {
        const int code = static_cast<int>(exit_code);
        has_failed_ = true;
        exit_code_ = exit_code_ == 0 ? code : exit_code_;
        close_outcome();
        if (options_.json) {
            output_.print(json_error_line(outcome_, error, code, reply));
        } else {
            print_error(error, code);
        }
        return options_.keep_going;
    }

    Session& session_;
    const ScriptOptions& options_;
    Output output_;
    CommandOutcome outcome_;
    double start_ms_ = 0;
    bool has_failed_ = false;
    int exit_code_ = 0;
};

}  // namespace

LineSource lines_of(int fd, MachinePort& machine) {
    return [reader = LineReader(fd, "standard input", machine)]() mutable { return reader.next(); };
}

LineSource lines_of_file(const std::string& path, MachinePort& machine) {
    // Non-blocking, because opening a named pipe would wait for its writer.
    const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0) {
        throw RequestError(ExitCode::bad_data,
                           fmt::format("{}: cannot be opened: {}", path, std::strerror(errno)));
    }
    const std::shared_ptr<void> closer(nullptr, [fd](void*) { close(fd); });
    return [reader = LineReader(fd, path, machine), closer]() mutable { return reader.next(); };
}

LineSource lines_of_prompt(MachinePort& machine) {
    return lines_of_prompt(waiting_in(machine));
}

int run_script(Session& session, const LineSource& next_line, const ScriptOptions& options) {
    Script script(session, options);
    const auto next = [&] {
        std::optional<std::string> line;
        bool goes_on = true;
        while (goes_on) {
            try {
                session.recovery.wait([&] { line = next_line(); });
                return line;
            } catch (const ContentLost& loss) {
                goes_on = script.tell_loss(loss);
            } catch (const MachineError& death) {
                script.tell_end_between(death);
                throw;
            }
        }
        return line;
    };
    for (std::optional<std::string> line; (line = next());) {
        if (!script.run_line(*line)) {
            break;
        }
    }
    return script.exit_code();
}

}  // namespace pxpl5::host
