#include "host/base/prompt.hpp"

#include <fmt/core.h>
#include <histedit.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <cwchar>
#include <exception>
#include <memory>
#include <utility>
#include <vector>

#include "host/base/command_line.hpp"
#include "host/base/error.hpp"
#include "host/base/kernel/standard_streams.hpp"

namespace pxpl5::host {

namespace {

constexpr int history_length = 500;

/// libedit wants a function that returns the prompt's text.
const char* prompt_text(EditLine*) {
    return "pxpl5> ";
}

struct Prompt {
    WaitReadable wait_readable;
    std::exception_ptr failure;  ///< Ended the wait for a key; libedit is C and cannot carry it.
    EditLine* line = el_init("pxpl5", stdin, stdout, stderr);
    ::History* past = history_init();        // libedit's.
    std::string unfinished;                  ///< Typed before a failure, for the next line.
    static inline Prompt* asking = nullptr;  ///< The prompt that reads a line.

    explicit Prompt(WaitReadable wait) : wait_readable(std::move(wait)) {
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
        if (!unfinished.empty()) {
            el_push(line, std::exchange(unfinished, "").c_str());
        }
        asking = this;
        redraw_after_notices([] { el_set(asking->line, EL_REFRESH); });
        const char* text = el_gets(line, &length);
        redraw_after_notices(nullptr);
        if (failure) {
            const LineInfo* const typed = el_line(line);
            // A search in the history puts its pattern behind a newline, which would run the line.
            unfinished.assign(typed->buffer,
                              std::find_if(typed->buffer, typed->lastchar, [](char c) {
                                  return std::iscntrl(static_cast<unsigned char>(c)) != 0;
                              }));
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
        for (char byte = 0;
             read_some(STDIN_FILENO, wait_readable, {&byte, 1}, "standard input") == 1;) {
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

/// Whether a word begins at `at`, outside quotes.
bool begins_word(std::string_view text, std::size_t at) {
    return at == 0 || std::string_view(" \t;\n").find(text[at - 1]) != std::string_view::npos;
}

/// Splits at ';' and newlines that stand outside quotes and comments.
std::vector<std::string> split_commands(std::string_view text) {
    std::vector<std::string> lines(1);
    char quote = 0;
    bool is_comment = false;
    for (std::size_t at = 0; at < text.size(); ++at) {
        const char c = text[at];
        is_comment = c != '\n' && (is_comment || (quote == 0 && begins_word(text, at) &&
                                                  begins_comment(text.substr(at))));
        if (is_comment) {
            lines.back() += c;
            continue;
        }
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

}  // namespace

std::size_t read_some(int fd, const WaitReadable& wait_readable, std::span<char> bytes,
                      const std::string& name) {
    for (;;) {
        if (wait_readable) {
            wait_readable(fd);
        }
        const ssize_t count = read(fd, bytes.data(), bytes.size());
        if (count >= 0 || errno == EBADF) {
            return count > 0 ? static_cast<std::size_t>(count) : 0;
        }
        if (errno != EINTR && errno != EAGAIN) {
            throw RequestError(ExitCode::bad_data,
                               fmt::format("{}: cannot be read: {}", name, std::strerror(errno)));
        }
    }
}

LineSource lines_of_text(const std::string& text) {
    return [lines = split_commands(text), at = std::size_t{0}]() mutable {
        return at < lines.size() ? std::optional(lines[at++]) : std::nullopt;
    };
}

LineSource lines_of_prompt(WaitReadable wait_readable) {
    return [prompt = std::make_shared<Prompt>(std::move(wait_readable))] { return prompt->ask(); };
}

}  // namespace pxpl5::host
