// Director: commands, questions, and restarts of dead machines.
#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/reply.hpp"
#include "host/commands/text/first_surfaces.hpp"
#include "host/serve/director/director.hpp"
#include "host/session/restore.hpp"

namespace pxpl5::host::serve {

namespace {

constexpr std::string_view download_prefix = "download:";
constexpr std::size_t max_name_bytes = 120;
/// Opacity of a surface around others, so that the first picture shows both.
constexpr const char* see_through = "0.35";

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

/// Whether both scenes give the same picture.
bool same_picture(const Scene& a, const Scene& b) {
    return same_parameters(a, b) && a.size == b.size;
}

}  // namespace

void Director::do_wish(const Wish& wish) {
    const Scene before = session_->scene;
    try {
        wish.is_ask ? answer_ask(wish) : do_command(wish);
    } catch (const RequestError& error) {
        refuse(wish, error);
    } catch (const MachineError& death) {
        if (!death.is_interruption) {
            refuse(wish, RequestError(ExitCode::failed, death.what()));
        }
        start_again(death, before);
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
    if (!download.empty()) {
        reply.fields.push_back({"download", "/download/" + download});
    }
    return reply;
}

void Director::do_command(const Wish& wish) {
    struct Work {
        Director& director;
        ~Work() {
            director.machine_->watch(-1, {});
            director.busy_.clear();
            director.end_progress();
        }
    };
    const Work work{*this};
    const Scene before = session_->scene;
    const int loads = session_->history.loads();
    const std::int64_t start_ns = parts_.clock_ns();
    cancels_ = false;
    if (find_command(wish.arguments.name).is_long) {
        busy_ = wish.text;
        tell_state();
        tell_progress(wish.arguments.name, 0, 0);
        machine_->watch(audience_.event_fd(), [this] {
            take_events();
            return cancels_;
        });
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
        announce_frame(wish.arguments);
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
        throw;  // The next machine draws again.
    } catch (const std::exception&) {
        note_change();
        throw;
    }
}

void Director::tell_opened() {
    const std::optional<std::string>& line = session_->history.load_line();
    const std::string path = line ? parse_line(*line).words.at(0) : "";
    if (path != std::exchange(opened_, path)) {
        audience_.opened(path);
    }
}

void Director::answer_ask(const Wish& wish) {
    if (!parts_.answer) {
        refuse_command("ask: this program answers no such question");
    }
    audience_.send_binary(wish.viewer, parts_.answer(*session_, *wish.id, wish.text));
}

Reply Director::open(const std::string& line) {
    state_is_old_ = true;
    ++revision_;
    return run(parse_line(line));
}

void Director::show_first_surfaces() {
    if (!session_->volumes.has_volume() || !session_->scene.surfaces.empty()) {
        return;
    }
    for (const FirstSurface& each : first_surfaces(session_->volumes.volume())) {
        Arguments command{"surface", {each.name}, {}};
        if (each.isovalue) {
            command.options["iso"] = fmt::format("{}", *each.isovalue);
        }
        if (each.seen_through) {
            command.options["opacity"] = see_through;
        }
        run_command(*session_, command);
    }
    // The surfaces belong to the load: undo does not go back beyond them.
    History& history = session_->history;
    if (const std::optional<std::string> load = history.load_line()) {
        history.begin_anew(*load);
        history.mark();
    }
}

/// Runs work that is no command. Starts the machine again if the machine dies.
void Director::guard(const std::string& what, const std::function<void()>& act) {
    const Scene before = session_->scene;
    try {
        act();
    } catch (const MachineError& death) {
        start_again(death, before);
    } catch (const std::exception& error) {
        note("error", fmt::format("{}: {}", what, error.what()));
    }
}

/// Reports the death. Throws it if the machine was interrupted or has died too often.
void Director::count_death(const MachineError& death) {
    if (death.is_interruption) {
        throw death;
    }
    deaths_ns_.push_back(parts_.clock_ns());
    if (deaths_ns_.size() > max_deaths) {
        deaths_ns_.pop_front();
    }
    if (deaths_ns_.size() == max_deaths && since_ms(deaths_ns_.front()) < death_window_ms) {
        note("error", fmt::format("The machine has died {} times within a minute. The last error: "
                                  "{}. The program ends.",
                                  max_deaths, death.what()));
        throw death;
    }
    note("error", fmt::format("The machine has died: {}. It is started again.", death.what()));
}

/// Loads the volume and restores the scene. The history continues.
void Director::start_again(const MachineError& death, Scene scene) {
    // If the launch fails, the session is gone.
    const History history = session_->history;
    busy_ = "starting the machine again";
    for (std::optional<MachineError> newest = death; newest;) {
        count_death(*newest);
        tell_progress(busy_, 0, 0);
        newest = try_again(history, scene);
    }
    busy_.clear();
    end_progress();
    state_is_old_ = true;
    ++revision_;
    input_ns_ = parts_.clock_ns();
}

/// Returns the error of the new machine, if it dies, too.
std::optional<MachineError> Director::try_again(const History& history, const Scene& scene) {
    try {
        start();
    } catch (const MachineError& death) {
        return death;
    } catch (const std::exception& error) {
        return MachineError(static_cast<int>(ExitCode::unavailable), error.what());
    }
    try {
        if (history.load_line()) {
            const Arguments load = parse_line(*history.load_line());
            find_command(load.name).run(*session_, load);
        }
        restore_all(*session_, scene);
        note("info", "The machine has restarted. Volume and surfaces are restored.");
    } catch (const MachineError& death) {
        return death;
    } catch (const std::exception& error) {
        note("error", fmt::format("A part was not restored: {}", error.what()));
    }
    session_->history = history;
    if (history.load_line() && !has_picture()) {
        session_->history.forget_load();
    }
    return std::nullopt;
}

}  // namespace pxpl5::host::serve
