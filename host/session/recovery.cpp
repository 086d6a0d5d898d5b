#include "host/session/recovery.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/stopwatch.hpp"
#include "host/session/session.hpp"

namespace pxpl5::host {

namespace {

constexpr int max_pause_ms = 60'000;
constexpr std::size_t max_restarts_kept = 100;
/// Restarts that follow each other sooner pause longer and longer.
constexpr double sound_ms = 60'000;

/// The section of the topology file that has the settings of `node`.
std::string_view section_of(const std::string& node) {
    return node.starts_with("renderer")      ? "renderer"
           : node.starts_with("framebuffer") ? "frame_buffer"
                                             : "gp";
}

/// The pause before the next restart, after a row of `restarts`.
int pause_ms(const RestartSettings& rule, int restarts) {
    int pause = restarts == 0 ? 0 : rule.backoff_ms;
    for (int n = 1; n < restarts && pause < max_pause_ms; ++n) {
        pause *= 2;
    }
    return std::min(pause, max_pause_ms);
}

[[noreturn]] void give_up(const MachineError& death, const std::string& reason = {}) {
    MachineError last(death.code,
                      reason.empty() ? death.what() : with_stop(death.what()) + " " + reason);
    last.node = death.node;
    last.is_final = true;
    throw last;
}

/// The nodes that the machine loses. Throws `death` if the last node of a role has died.
NodeChange change_of(const RestartSettings& rule, const MachineError& death,
                     const Conversation& conversation) {
    const std::string_view section = section_of(death.node);
    if (rule.policy != RestartPolicy::degrade || death.node.empty() || section == "frame_buffer") {
        return {};
    }
    const bool is_gp = section == "gp";
    if ((is_gp ? conversation.gps().size() : conversation.renderer_count()) <= 1) {
        give_up(death, fmt::format("The machine cannot continue without it: it was the last {}",
                                   is_gp ? "GP" : "Renderer"));
    }
    return is_gp ? NodeChange{-1, 0} : NodeChange{0, -1};
}

}  // namespace

std::string nodes_text(int gps, int renderers) {
    return fmt::format("{} GP{}, {} Renderer{}", gps, gps == 1 ? "" : "s", renderers,
                       renderers == 1 ? "" : "s");
}

void Recovery::tell(const std::string& text, bool is_over) const {
    if (tell_) {
        tell_(text, is_over);
    }
}

void Recovery::run(const std::function<void()>& act, bool is_wait) {
    const Scene before = session_.scene;
    std::optional<Attempt> attempt;
    for (int number = 1;; ++number) {
        bool is_acting = !attempt;
        try {
            if (attempt) {
                start_again(*attempt, before);
                is_acting = true;
            }
            act();
            return;
        } catch (const MachineError& death) {
            if (death.is_interruption || death.is_final) {
                throw;
            }
            if (is_acting && ms_since(restored_ns_) > sound_ms) {
                row_ = 0;
                number = is_wait ? 1 : number;
            }
            attempt = plan(death, number,
                           attempt && !attempt->has_started ? attempt->change : NodeChange{});
        }
    }
}

Recovery::Attempt Recovery::plan(const MachineError& death, int number,
                                 const NodeChange& unfinished) {
    const RestartSettings rule = session_.conversation.machine().restart_of(death.node);
    if (rule.policy == RestartPolicy::end) {
        give_up(death);
    }
    if (number > rule.max) {
        const std::string starts =
            number == 1 ? ""
                        : fmt::format("The machine was started again {} time{} for this work; ",
                                      number - 1, number == 2 ? "" : "s");
        give_up(death, fmt::format("{0}{1}.restart.max is {2}, and --set {1}.restart.max=N changes "
                                   "this",
                                   starts, section_of(death.node), rule.max));
    }
    Attempt next{death.node, death.what(), unfinished, pause_ms(rule, row_++), now_ns()};
    if (unfinished.gps == 0 && unfinished.renderers == 0) {
        next.change = change_of(rule, death, session_.conversation);
    }
    const std::string pause =
        next.pause_ms == 0
            ? ""
            : fmt::format(" after a pause of {:g} s", static_cast<double>(next.pause_ms) / 1000);
    tell(fmt::format("{} The machine is started again{} (restart {} of {})",
                     with_stop(death.what()), pause, number, rule.max),
         false);
    return next;
}

void Recovery::start_again(Attempt& attempt, const Scene& before) {
    session_.conversation.machine().start_again(attempt.change, attempt.pause_ms);
    attempt.has_started = true;
    try {
        session_.begin_again_or_drop(before);
    } catch (const ContentLost&) {
        note_restart(attempt, false);
        throw;
    }
    note_restart(attempt, true);
}

void Recovery::note_restart(const Attempt& attempt, bool is_restored) {
    restored_ns_ = now_ns();
    Restart done{attempt.node,
                 attempt.cause,
                 static_cast<int>(session_.conversation.gps().size()),
                 static_cast<int>(session_.conversation.renderer_count()),
                 ms_since(attempt.died_ns),
                 is_restored};
    tell(fmt::format("The machine runs again with {}. {} after {:.0f} ms",
                     nodes_text(done.gps, done.renderers),
                     is_restored ? "Everything is restored" : "Nothing is loaded", done.ms),
         true);
    restarts_.push_back(std::move(done));
    if (restarts_.size() > max_restarts_kept) {
        restarts_.erase(restarts_.begin());
    }
}

}  // namespace pxpl5::host
