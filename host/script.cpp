#include "host/script.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <histedit.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <cwchar>
#include <exception>
#include <memory>
#include <span>
#include <utility>

#include "host/commands.hpp"
#include "host/error.hpp"

namespace pxpl5::host {

namespace {

constexpr int history_length = 500;

/// libedit wants a function that returns the prompt's text.
const char* prompt_text(EditLine*) {
    return "pxpl5> ";
}

constexpr std::size_t chunk_bytes = 4096;

/// Waits until `fd` is readable, looking after `machine`, and reads. Returns how many bytes came;
/// 0 at the end, which a closed descriptor has reached. Throws RequestError naming `name`.
std::size_t read_some(int fd, MachinePort* machine, std::span<char> bytes,
                      const std::string& name) {
    for (;;) {
        if (machine != nullptr) {
            machine->wait_readable(fd);
        }
        const ssize_t count = read(fd, bytes.data(), bytes.size());
        if (count >= 0 || errno == EBADF) {
            return count > 0 ? static_cast<std::size_t>(count) : 0;
        }
        if (errno != EINTR && errno != EAGAIN) {
            throw RequestError(ExitCode::usage,
                               fmt::format("{}: cannot be read: {}", name, std::strerror(errno)));
        }
    }
}

/// Cuts what a descriptor yields into lines.
class LineReader {
  public:
    LineReader(int fd, std::string name, MachinePort& machine)
        : fd_(fd), name_(std::move(name)), machine_(machine) {}

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
            const std::size_t count = read_some(fd_, &machine_, chunk, name_);
            if (count == 0) {
                return text_.empty() ? std::nullopt : std::optional(std::exchange(text_, {}));
            }
            text_.append(chunk.data(), count);
        }
    }

  private:
    int fd_;
    std::string name_;
    MachinePort& machine_;
    std::string text_;  ///< Read, but not handed out.
};

struct Prompt {
    MachinePort* machine;
    std::exception_ptr failure;  ///< Ended the wait for a key; libedit is C and cannot carry it.
    EditLine* line = el_init("pxpl5", stdin, stdout, stderr);
    ::History* past = history_init();  // libedit's.

    explicit Prompt(MachinePort* port) : machine(port) {
        HistEvent event;
        history(past, &event, H_SETSIZE, history_length);
        el_set(line, EL_PROMPT, &prompt_text);
        el_set(line, EL_EDITOR, "emacs");
        el_set(line, EL_HIST, history, past);
        el_set(line, EL_CLIENTDATA, this);
        el_set(line, EL_GETCFN, &read_key);
    }
    Prompt(const Prompt&) = delete;
    Prompt& operator=(const Prompt&) = delete;
    ~Prompt() {
        history_end(past);
        el_end(line);
    }
    std::optional<std::string> ask() {
        int length = 0;
        const char* text = el_gets(line, &length);
        if (failure) {
            std::fputc('\n', stdout);  // The cursor stands behind the prompt.
            std::rethrow_exception(std::exchange(failure, nullptr));
        }
        if (text == nullptr || length <= 0) {
            return std::nullopt;
        }
        HistEvent event;
        history(past, &event, H_ENTER, text);
        std::string answer(text, static_cast<std::size_t>(length));
        answer.erase(answer.find_last_not_of("\r\n") + 1);
        return answer;
    }

    /// libedit's source of characters. Returns 1, or 0 at the end.
    static int read_key(EditLine* line, wchar_t* key) {
        void* self = nullptr;
        el_get(line, EL_CLIENTDATA, &self);
        Prompt& prompt = *static_cast<Prompt*>(self);
        try {
            return prompt.next_key(*key) ? 1 : 0;
        } catch (...) {
            prompt.failure = std::current_exception();
            return 0;  // So that it gives the terminal back.
        }
    }

    /// The next character of the terminal, whose bytes may come one by one.
    bool next_key(wchar_t& key) const {
        std::mbstate_t state{};
        for (char byte = 0; read_some(STDIN_FILENO, machine, {&byte, 1}, "standard input") == 1;) {
            const std::size_t used = std::mbrtowc(&key, &byte, 1, &state);
            if (used <= 1) {
                return true;
            }
            if (used == static_cast<std::size_t>(-1)) {
                state = {};  // No character of this locale: left out.
            }
        }
        return false;
    }
};

/// Splits at ';' and newlines that stand outside quotes.
std::vector<std::string> split_commands(const std::string& text) {
    std::vector<std::string> lines(1);
    char quote = 0;
    for (const char c : text) {
        if (quote == 0 && (c == ';' || c == '\n')) {
            lines.emplace_back();
            continue;
        }
        if (c == quote) {
            quote = 0;
        } else if (quote == 0 && (c == '"' || c == '\'')) {
            quote = c;
        }
        lines.back() += c;
    }
    return lines;
}

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

LineSource lines_of_text(const std::string& text) {
    return [lines = split_commands(text), at = std::size_t{0}]() mutable {
        return at < lines.size() ? std::optional(lines[at++]) : std::nullopt;
    };
}

LineSource lines_of_prompt(MachinePort* machine) {
    return [prompt = std::make_shared<Prompt>(machine)] { return prompt->ask(); };
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
