// Director: the warning before the end of the program, and the session that is saved for later.
#include <fmt/chrono.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <system_error>
#include <utility>

#include "host/base/error.hpp"
#include "host/machine/run_folder.hpp"
#include "host/serve/director/director.hpp"
#include "host/serve/director/shell_word.hpp"

namespace pxpl5::host::serve {

namespace {

constexpr double ms_per_s = 1000;

}  // namespace

double idle_warning_ms(double limit_ms) {
    constexpr double usual_ms = 120'000;
    return std::min(usual_ms, limit_ms / 2);
}

double Director::idle_left_ms() const {
    return parts_.idle_limit_ms - since_ms(end_.used_ns);
}

bool Director::is_idle_too_long() const {
    return parts_.idle_limit_ms > 0 && idle_left_ms() <= 0;
}

/// Announces the end of an unused session, or takes the announcement back. Returns whether
/// something has changed.
bool Director::warn_of_idle_end() {
    const double left_ms = idle_left_ms();
    const bool is_near =
        parts_.idle_limit_ms > 0 && left_ms > 0 && left_ms <= idle_warning_ms(parts_.idle_limit_ms);
    if (is_near && !end_.notice) {
        take(EndsSoon{std::time(nullptr) + std::lround(left_ms / ms_per_s),
                      "it has not been used for some time. Any action here keeps it open"});
        end_.is_because_idle = true;
        return true;
    }
    if (!is_near && end_.is_because_idle) {
        end_.is_because_idle = false;
        end_.notice.reset();
        state_is_old_ = true;
        if (parts_.tell_end_notice) {
            parts_.tell_end_notice({});
        }
        return true;
    }
    return false;
}

void Director::take(const EndsSoon& soon) {
    end_.is_because_idle = false;
    end_.saved_revision = 0;  // The notice names the file again.
    end_.notice = EndNotice{};
    end_.notice->why = soon.why;
    if (soon.at_s != 0) {
        end_.notice->at = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(soon.at_s));
    }
    state_is_old_ = true;
    if (!busy_.empty() || work_.waits) {
        note("error", sentence_of(*end_.notice));  // The state comes after the work.
    }
    if (parts_.tell_end_notice) {
        parts_.tell_end_notice(*end_.notice);
    }
}

/// True before the end, after the user's input has come to rest.
bool Director::is_save_due() const {
    return end_.notice && end_.saved_revision != revision_ && since_ms(input_ns_) >= rest_ms;
}

/// Writes the scene as a script. Names the file, or the problem, in `notice`.
void Director::write_session(EndNotice& notice) {
    try {
        make_private_folder(parts_.saved_session.parent_path());
        const Arguments save{"history", {parts_.saved_session.string()}, {{"form", "scene"}}};
        find_command(save.name).run(*session_, save);
        std::filesystem::permissions(parts_.saved_session, std::filesystem::perms::owner_read |
                                                               std::filesystem::perms::owner_write);
        notice.saved = parts_.saved_session.string();
        notice.open = fmt::format("pxpl5 serve --session {}", shell_word(notice.saved));
        notice.problem.clear();
    } catch (const MachineError&) {
        throw;
    } catch (const std::exception& error) {
        notice.problem = fmt::format("The session cannot be saved: {}", error.what());
    }
}

/// Saves the session before a restart, which may fail and lose the scene. Without contents, as in a
/// load, there is no scene to save.
void Director::keep_session() {
    const bool has_contents =
        session_->volumes.has_volume() || session_->volumes.archive() != nullptr;
    if (has_contents && !parts_.saved_session.empty()) {
        write_session(end_.kept);
    }
}

/// Removes the file of keep_session(), unless the user has been told of it.
void Director::drop_kept_session() {
    if (!std::exchange(end_.kept, {}).saved.empty() &&
        (!end_.notice || end_.notice->saved.empty())) {
        std::error_code ignored;
        std::filesystem::remove(parts_.saved_session, ignored);
    }
}

/// Tells where the session of keep_session() is, because the program ends.
void Director::tell_kept_session(const std::string& why) {
    if (end_.kept.saved.empty() && end_.kept.problem.empty()) {
        return;
    }
    end_.notice = end_.kept;
    end_.notice->why = why;
    if (!end_.notice->problem.empty()) {
        note("error", end_.notice->problem);
    }
    if (parts_.tell_end_notice) {
        parts_.tell_end_notice(*end_.notice);
    }
}

/// Saves the session, again after each change.
void Director::save_session() {
    end_.saved_revision = revision_;
    EndNotice& notice = *end_.notice;
    const EndNotice before = notice;
    write_session(notice);
    if (notice.saved == before.saved && notice.problem == before.problem) {
        return;
    }
    state_is_old_ = true;
    if (!notice.problem.empty()) {
        note("error", notice.problem);
    }
    if (parts_.tell_end_notice) {
        parts_.tell_end_notice(notice);
    }
}

}  // namespace pxpl5::host::serve
