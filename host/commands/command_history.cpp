// Commands about what was done: undo, redo, mark, history, play.
#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string_view>

#include "host/base/answer.hpp"
#include "host/base/chart_axis.hpp"
#include "host/base/error.hpp"
#include "host/base/part_file.hpp"
#include "host/commands/command_handlers.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/text/scene_script.hpp"
#include "host/session/restore.hpp"

namespace pxpl5::host {

namespace {

constexpr std::uintmax_t max_script_bytes = std::uintmax_t{16} << 20;
constexpr int max_play_depth = 8;  ///< Depth of scripts that play scripts.

/// Puts back a scene of the history, which `note` then tells of the one that was left.
Reply go_to(Session& session, const Scene& scene, const char* done,
            const std::optional<std::string>& line, void (History::*note)(const Scene&)) {
    const Scene before = session.scene;
    restore(session, scene);
    (session.history.*note)(before);
    return {fmt::format("{}: {}", done, line.value_or("")), {{"line", line.value_or("")}}};
}

/// Writes into what is no regular file, for example a pipe. Returns why that failed, or nothing.
std::string write_device(const std::string& path, std::string_view text) {
    // O_NONBLOCK: opening a FIFO that no program reads would wait for ever.
    const int fd = open(path.c_str(), O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    while (fd >= 0 && !text.empty()) {
        const ssize_t written = ::write(fd, text.data(), text.size());
        if (written < 0 && errno != EINTR) {
            break;
        }
        text.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(written, 0)));
    }
    const std::string reason = fd < 0 || !text.empty() ? std::strerror(errno) : "";
    if (fd >= 0) {
        close(fd);
    }
    return reason;
}

/// A script is whole or not there.
void write_script(const std::string& path, const std::string& text) {
    std::error_code error;
    const std::filesystem::file_status there = std::filesystem::status(path, error);
    std::string reason;
    if (std::filesystem::exists(there) && !std::filesystem::is_regular_file(there)) {
        reason = write_device(path, text);
    } else {
        remove_abandoned_parts(path);
        PartFile file(path);
        file.write(text);
        reason = file.keep();
    }
    if (!reason.empty()) {
        throw RequestError(ExitCode::failed,
                           fmt::format("history: '{}' cannot be written: {}", path, reason));
    }
}

std::string read_script(const std::string& path) {
    std::error_code error;
    if (const std::string reason = why_unreadable(path); !reason.empty()) {
        throw RequestError(ExitCode::bad_data, fmt::format("{}: {}", path, reason));
    }
    const std::uintmax_t bytes = std::filesystem::file_size(path, error);
    if (error || bytes > max_script_bytes) {
        throw RequestError(ExitCode::bad_data,
                           fmt::format("{}: has {} bytes; at most {} are read", path,
                                       grouped(bytes), grouped(max_script_bytes)));
    }
    std::ifstream file(path, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(file), {}};
    if (!file) {
        throw RequestError(ExitCode::bad_data, fmt::format("{}: cannot be read", path));
    }
    return text;
}

/// Counts scripts that play each other, so that a circle of them ends.
class PlayDepth {
  public:
    PlayDepth(History& history, const std::string& path) : history_(history) {
        if (history.plays() == max_play_depth) {
            throw RequestError(ExitCode::usage,
                               fmt::format("play: '{}' is played by {} scripts within each other, "
                                           "no more may",
                                           path, max_play_depth));
        }
        history_.begin_play();
    }
    ~PlayDepth() { history_.end_play(); }
    PlayDepth(const PlayDepth&) = delete;
    PlayDepth& operator=(const PlayDepth&) = delete;

  private:
    History& history_;
};

}  // namespace

Reply run_undo(Session& session, const Arguments&) {
    History& history = session.history;
    return go_to(session, history.before_last(), "undone", history.undo_line(), &History::undone);
}

Reply run_redo(Session& session, const Arguments&) {
    History& history = session.history;
    return go_to(session, history.after_next(), "done again", history.redo_line(),
                 &History::redone);
}

Reply run_mark(Session& session, const Arguments&) {
    session.history.mark();
    return {};
}

Reply run_history(Session& session, const Arguments& arguments) {
    const std::string script = arguments.text("form", "steps") == "scene"
                                   ? scene_script(session)
                                   : session.history.script();
    Reply reply{script.substr(0, script.find_last_not_of('\n') + 1), {{"script", script}}};
    if (!arguments.words.empty()) {
        const std::string& path = arguments.words[0];
        write_script(path, script);
        reply = {fmt::format("wrote {}", path), {{"script", script}, {"file", path}}};
    }
    return reply;
}

Reply run_play(Session& session, const Arguments& arguments) {
    const std::string& path = arguments.words[0];
    const PlayDepth depth(session.history, path);
    std::istringstream script(read_script(path));
    std::int64_t done = 0;
    int number = 1;
    for (std::string line; std::getline(script, line); ++number) {
        try {
            const Arguments command = parse_line(line);
            if (command.name.empty()) {
                continue;
            }
            if (is_quit(command)) {
                break;
            }
            run_command(session, command);
            ++done;
        } catch (const Canceled&) {
            throw;
        } catch (const RequestError& error) {
            throw RequestError(
                error.code, fmt::format("{}, line {}, '{}': {}", path, number, line, error.what()));
        }
    }
    const std::string commands = counted(static_cast<std::uint64_t>(done), "command");
    return {fmt::format("played {} of {}", commands, path), {{"file", path}, {"commands", done}}};
}

}  // namespace pxpl5::host
