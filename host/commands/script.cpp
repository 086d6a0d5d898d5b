#include "host/commands/script.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <memory>
#include <utility>

#include "host/base/error.hpp"
#include "host/commands/commands.hpp"

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

/// Prints one outcome as it happens, so that a watcher of a pipe sees progress.
/// Throws OutputLost (failed) if that cannot be done.
void print(const std::string& text) {
    if (text.empty()) {
        return;
    }
    const std::string line = text + '\n';
    std::fwrite(line.data(), 1, line.size(), stdout);
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
        throw OutputLost(ExitCode::failed, fmt::format("standard output cannot be written: {}",
                                                       std::strerror(errno)));
    }
}

}  // namespace

LineSource lines_of(int fd, MachinePort& machine) {
    return [reader = LineReader(fd, "standard input", machine)]() mutable { return reader.next(); };
}

LineSource lines_of_file(const std::string& path, MachinePort& machine) {
    // Non-blocking, because opening a named pipe would wait for its writer.
    const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0) {
        throw RequestError(ExitCode::usage,
                           fmt::format("{}: cannot be opened: {}", path, std::strerror(errno)));
    }
    const std::shared_ptr<void> closer(nullptr, [fd](void*) { close(fd); });
    return [reader = LineReader(fd, path, machine), closer]() mutable { return reader.next(); };
}

LineSource lines_of_prompt(MachinePort& machine) {
    return lines_of_prompt(waiting_in(machine));
}

int run_script(Session& session, const LineSource& next_line, const ScriptOptions& options) {
    int exit_code = 0;
    while (const std::optional<std::string> line = next_line()) {
        const auto start = std::chrono::steady_clock::now();
        const auto elapsed_ms = [start] {
            return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() -
                                                             start)
                .count();
        };
        try {
            const Arguments arguments = parse_line(*line);
            if (arguments.name.empty()) {
                continue;
            }
            if (is_quit(arguments)) {
                return exit_code;
            }
            if (options.echo && !options.json) {
                print("> " + *line);
            }
            const Reply reply = run_command(session, arguments);
            print(options.json ? json_line(*line, reply, elapsed_ms()) : reply.text);
        } catch (const OutputLost&) {
            throw;  // Not the command's failure, and nobody would see the next one's answer.
        } catch (const RequestError& error) {
            const int code = static_cast<int>(error.code);
            exit_code = exit_code == 0 ? code : exit_code;
            if (options.json) {
                print(json_error_line(*line, error.what(), code, elapsed_ms()));
            } else {
                // If this cannot be written either, nobody can be told.
                std::fprintf(stderr, "error: %s\n", error.what());
            }
            if (!options.keep_going) {
                return exit_code;
            }
        }
    }
    return exit_code;
}

}  // namespace pxpl5::host
