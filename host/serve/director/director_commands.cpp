// Director: commands, questions, and what viewers hear of restarts.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <string_view>
#include <utility>
#include <variant>

#include "host/base/error.hpp"
#include "host/base/reply.hpp"
#include "host/commands/text/first_surfaces.hpp"
#include "host/serve/director/director.hpp"
#include "host/session/restore.hpp"

namespace pxpl5::host::serve {

namespace {

constexpr std::string_view download_prefix = "download:";
constexpr std::size_t max_name_bytes = 120;
/// Opacity of a surface around others, so that the first picture shows both, and its rim, so that
/// its outline is seen.
constexpr const char* see_through = "0.25";
constexpr const char* seen_rim = "0.75";

/// A file's name without a path. Throws RequestError.
void check_name(const std::string& name) {
    const bool is_plain = std::ranges::all_of(name, [](unsigned char c) {
        return std::isalnum(c) != 0 || c == '.' || c == '_' || c == '-' || c == ' ';
    });
    if (name.empty() || name.size() > max_name_bytes || name.front() == '.' || !is_plain) {
        refuse_command(
            fmt::format("download: '{}' is no name for a file; letters, digits, '.', "
                        "'_', '-' and blanks make one, up to {}",
                        name, max_name_bytes));
    }
}

/// Throws RequestError if the command writes a file, or changes the machine: an invitation writes
/// the key, and other computers get programs and the volume.
void refuse_output(const CommandDescriptor& command, const Arguments& arguments) {
    constexpr std::array<std::string_view, 3> of_machine = {"computers", "kill", "scale"};
    if (std::ranges::count(of_machine, command.name) > 0) {
        refuse_command(
            fmt::format("{}: acts on the machine, but a session that is opened only shows a scene. "
                        "If you trust its commands, run them with: pxpl5 run FILE",
                        command.name));
    }
    const std::size_t words = std::min(arguments.words.size(), command.words.size());
    for (std::size_t i = 0; i < words; ++i) {
        if (command.words[i].type == ValueType::output) {
            refuse_command(
                fmt::format("{}: would write {}, but a session that is opened writes no file. If "
                            "you trust its commands, run them with: pxpl5 run FILE",
                            command.name, arguments.words[i]));
        }
    }
}

/// Whether both scenes give the same picture.
bool same_picture(const Scene& a, const Scene& b) {
    return same_parameters(a, b) && a.size == b.size && a.detail == b.detail &&
           a.stereo == b.stereo;
}

}  // namespace

void Director::do_wish(const Wish& wish) {
    try {
        if (wish.is_ask) {
            session_->recovery.run([&] { answer_ask(wish); });
        } else {
            do_command(wish);
        }
    } catch (const RequestError& error) {
        refuse(wish, error);
    } catch (const MachineError& death) {
        if (!death.is_interruption) {
            refuse(wish, RequestError(ExitCode::failed, death.what()));
        }
        tell_end(death);
        throw;
    } catch (const std::exception& error) {  // For example a file system's error.
        refuse(wish, RequestError(ExitCode::failed, error.what()));
    }
}

/// Runs a command. "download:NAME" becomes a path in the folder of downloads.
Reply Director::run(const Arguments& arguments) {
    Arguments placed = arguments, noted = arguments;
    std::string download;
    for (std::size_t i = 0; i < placed.words.size(); ++i) {
        if (placed.words[i].starts_with(download_prefix)) {
            download = placed.words[i].substr(download_prefix.size());
            check_name(download);
            placed.words[i] = (parts_.downloads / download).string();
            noted.words[i] = download;  // A script writes into its current folder.
        }
    }
    Reply reply = run_command(*session_, placed, &noted);
    end_.used_ns = parts_.clock_ns();
    if (!download.empty()) {
        reply.fields.push_back({"download", "download/" + download});
    }
    return reply;
}

void Director::do_command(const Wish& wish) {
    struct UnderWay {
        Director& director;
        ~UnderWay() {
            director.work_.is_command = false;
            director.end_.used_ns = director.parts_.clock_ns();
            director.watch_viewers();  // Forgets a cancellation that came too late.
            director.busy_.clear();
            director.end_progress();
        }
    };
    const UnderWay under_way{*this};
    const Scene before = session_->scene;
    const int loads = session_->history.loads();
    std::optional<History> former;
    if (wish.arguments.name == "play") {
        former = session_->history;
    }
    const std::int64_t start_ns = parts_.clock_ns();
    watch_viewers();  // Forgets an earlier cancellation.
    work_.cancels = false;
    work_.is_command = true;
    if (find_command(wish.arguments.name).is_long) {
        busy_ = wish.text;
        tell_state();
        tell_progress(wish.arguments.name, 0, 0);
    }
    const auto note_change = [&] {
        state_is_old_ |= kind_of(wish.arguments) != CommandKind::question || !busy_.empty();
        tell_opened();
        if (loads != session_->history.loads() || !same_picture(before, session_->scene)) {
            ++revision_;
            state_is_old_ = true;
            input_ns_ = parts_.clock_ns();
        }
    };
    try {
        session_->recovery.run([&] { announce_frame(wish.arguments); });
        const Reply reply = run(wish.arguments);
        if (wish.arguments.name == "load") {
            show_first_surfaces();
        }
        note_change();
        if (wish.id) {
            audience_.send(wish.viewer, json_text({{"re", std::int64_t{*wish.id}},
                                                   {"ok", true},
                                                   {"text", reply.text},
                                                   {"result", reply.fields},
                                                   {"ms", since_ms(start_ns)},
                                                   {"revision", std::int64_t{revision_}}}));
        }
    } catch (const MachineError&) {
        throw;
    } catch (const RequestError& error) {
        const bool is_lost = former && loads != session_->history.loads();
        const bool is_back = is_lost && put_back(*former, before);
        note_change();
        if (is_back) {
            throw RequestError(error.code,
                               with_stop(error.what()) + " The scene before it is open again.");
        }
        throw;
    } catch (const std::exception&) {
        note_change();
        throw;
    }
}

/// Runs a command that asks no node while the session waits for nodes, or soon will for a command
/// that came before: a node may be stuck. Returns false if the command must wait for its turn.
bool Director::do_at_once(const Wish& wish) {
    const bool may_be_stuck = work_.waits || inbox_.has_command();
    if (!may_be_stuck || (wish.arguments.name != "kill" && wish.arguments.name != "stats")) {
        return false;
    }
    const Command& command = find_command(wish.arguments.name);
    check_arguments(command, wish.arguments);
    const Reply reply = command.run(*session_, wish.arguments);
    if (wish.id) {
        audience_.send(wish.viewer, json_text({{"re", std::int64_t{*wish.id}},
                                               {"ok", true},
                                               {"text", reply.text},
                                               {"result", reply.fields},
                                               {"ms", 0.0},
                                               {"revision", std::int64_t{revision_}}}));
    }
    return true;
}

/// Restores the scene before a session file that has failed after it opened a volume. Returns
/// whether the scene is back.
bool Director::put_back(const History& history, const Scene& scene) {
    if (!history.load_line()) {
        return false;
    }
    work_.cancels = false;
    try {
        session_->recovery.run([&] {
            const Arguments load = parse_line(*history.load_line());
            find_command(load.name).run(*session_, load);
            restore_all(*session_, scene);
        });
    } catch (const RequestError& error) {
        note("error", fmt::format("The scene before it cannot be opened: {}", error.what()));
        return false;
    }
    session_->history = history;
    return true;
}

void Director::tell_opened() {
    const std::optional<std::string>& line = session_->history.load_line();
    const std::string path = line ? parse_line(*line).words.at(0) : "";
    if (path != std::exchange(opened_, path)) {
        audience_.opened(path);
    }
}

void Director::answer_ask(const Wish& wish) {
    if (parts_.answer_later && parts_.answer_later(*session_, wish.viewer, *wish.id, wish.text)) {
        return;
    }
    if (!parts_.answer) {
        refuse_command("ask: this program answers no such question");
    }
    audience_.send_binary(wish.viewer, parts_.answer(*session_, *wish.id, wish.text));
}

/// Answers the waiting questions for slices also while a picture is drawn, if they need no node.
/// Other questions wait for the picture, and a viewer's newest question replaces its older one.
void Director::answer_slices() {
    if (session_->volumes.has_volume() && session_->volumes.volume().reduced) {
        return;
    }
    while (const std::optional<Wish> ask = inbox_.take_ask("slice ")) {
        try {
            answer_ask(*ask);
        } catch (const RequestError& error) {
            refuse(*ask, error);
        }
    }
}

Reply Director::open(const std::string& line) {
    state_is_old_ = true;
    ++revision_;
    session_->check_command = {};  // The user's own command, from the terminal.
    Reply reply = run(parse_line(line));
    session_->check_command = parts_.check_command;
    return reply;
}

void Director::open_session(const std::string& file) {
    state_is_old_ = true;
    ++revision_;
    session_->check_command = refuse_output;
    const Reply played = run({"play", {file}, {}});
    session_->check_command = parts_.check_command;
    for (const auto& [name, value] : played.fields) {
        const auto* const count = std::get_if<std::int64_t>(&value);
        if (name == "commands" && count != nullptr && *count == 0) {
            throw RequestError(
                ExitCode::bad_data,
                fmt::format("{}: no saved session: there is no command in it", file));
        }
    }
}

void Director::show_first_surfaces() {
    if (!session_->volumes.has_volume()) {
        return;
    }
    const bool is_empty = session_->scene.surfaces.empty();
    for (const FirstSurface& each :
         is_empty ? first_surfaces(session_->volumes.volume()) : std::vector<FirstSurface>{}) {
        Arguments command{"surface", {each.name}, {}};
        if (each.isovalue) {
            command.options["iso"] = fmt::format("{}", *each.isovalue);
        }
        if (each.seen_through) {
            command.options["opacity"] = see_through;
            command.options["rim"] = seen_rim;
        }
        run_command(*session_, command);
    }
    run_command(*session_, {"view", {"anterior"}, {{"fit", "yes"}}});
    // Surfaces and view belong to the load: undo does not go back beyond them.
    History& history = session_->history;
    if (const std::optional<std::string> load = history.load_line()) {
        history.begin_anew(*load);
        history.mark();
    }
}

/// Runs work that is no command. Starts the machine again if a node dies.
void Director::guard(const std::string& what, const std::function<void()>& act) {
    try {
        session_->recovery.run(act);
    } catch (const MachineError& death) {
        tell_end(death);
        throw;
    } catch (const std::exception& error) {
        note("error", fmt::format("{}: {}", what, error.what()));
    }
}

/// Tells the viewers that the machine is started again, or that it runs again.
void Director::tell_restart(const std::string& text, bool is_over) {
    note(is_over ? "info" : "error", text);
    if (parts_.tell_restart) {
        parts_.tell_restart(text, is_over);
    }
    if (!is_over) {
        if (!is_restarting_) {
            keep_session();
            busy_before_ = std::exchange(busy_, "starting the machine again");
        }
        is_restarting_ = true;
        tell_progress(busy_, 0, 0);
        return;
    }
    is_restarting_ = false;
    drop_kept_session();
    busy_ = std::exchange(busy_before_, "");
    end_progress();
    session_->recovery.take_restarts();
    tell_opened();
    state_is_old_ = true;
    ++revision_;  // The frames under way are lost.
    input_ns_ = parts_.clock_ns();
}

/// Tells the viewers why the program ends, and saves the scene, which needs no machine.
void Director::tell_end(const MachineError& death) {
    if (death.is_interruption) {
        return;
    }
    note("error", with_stop(death.what()) + " The program ends.");
    if (!is_restarting_) {
        keep_session();
    }
    tell_kept_session(death.what());
}

}  // namespace pxpl5::host::serve
