#include "host/script.hpp"

#include <fmt/core.h>
#include <histedit.h>

#include <chrono>
#include <cstdio>
#include <memory>

#include "host/commands.hpp"
#include "host/error.hpp"

namespace pxpl5::host {

namespace {

constexpr int history_length = 500;

/// libedit wants a function that returns the prompt's text.
const char* prompt_text(EditLine*) {
    return "pxpl5> ";
}

struct Prompt {
    EditLine* line = el_init("pxpl5", stdin, stdout, stderr);
    History* past = history_init();

    Prompt() {
        HistEvent event;
        history(past, &event, H_SETSIZE, history_length);
        el_set(line, EL_PROMPT, &prompt_text);
        el_set(line, EL_EDITOR, "emacs");
        el_set(line, EL_HIST, history, past);
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
        if (text == nullptr || length <= 0) {
            return std::nullopt;
        }
        HistEvent event;
        history(past, &event, H_ENTER, text);
        std::string answer(text, static_cast<std::size_t>(length));
        answer.erase(answer.find_last_not_of("\r\n") + 1);
        return answer;
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

/// Prints one outcome as it happens, so that a watcher of a pipe sees progress.
void print(std::FILE* to, const std::string& text) {
    if (!text.empty()) {
        fmt::print(to, "{}\n", text);
        std::fflush(to);
    }
}

}  // namespace

LineSource lines_of(std::istream& stream) {
    return [&stream]() -> std::optional<std::string> {
        std::string line;
        return std::getline(stream, line) ? std::optional(line) : std::nullopt;
    };
}

LineSource lines_of_text(const std::string& text) {
    return [lines = split_commands(text), at = std::size_t{0}]() mutable {
        return at < lines.size() ? std::optional(lines[at++]) : std::nullopt;
    };
}

LineSource lines_of_prompt() {
    return [prompt = std::make_shared<Prompt>()] { return prompt->ask(); };
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
                print(stdout, "> " + *line);
            }
            const Reply reply = run_command(session, arguments);
            print(stdout, options.json ? json_line(*line, reply, elapsed_ms()) : reply.text);
        } catch (const RequestError& error) {
            const int code = static_cast<int>(error.code);
            exit_code = exit_code == 0 ? code : exit_code;
            print(options.json ? stdout : stderr,
                  options.json ? json_error_line(*line, error.what(), code, elapsed_ms())
                               : std::string("error: ") + error.what());
            if (!options.keep_going) {
                return exit_code;
            }
        }
    }
    return exit_code;
}

}  // namespace pxpl5::host
