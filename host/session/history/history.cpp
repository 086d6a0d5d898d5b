#include "host/session/history/history.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "host/base/command_line.hpp"

namespace pxpl5::host {

namespace {

constexpr const char* undo_word = "undo";

bool same_parameters(const Surface& a, const Surface& b) {
    return a.name == b.name && a.isovalue == b.isovalue && a.table == b.table &&
           a.color == b.color && a.cull_back == b.cull_back && a.visible == b.visible &&
           a.opacity == b.opacity && a.rim == b.rim && a.components == b.components &&
           a.compared_with == b.compared_with;
}

bool has_surface(const Scene& scene, const std::string& name) {
    return std::ranges::count(scene.surfaces, name, &Surface::name) != 0;
}

}  // namespace

bool same_parameters(const Scene& a, const Scene& b) {
    return a.frame == b.frame && a.camera == b.camera && a.lights == b.lights &&
           a.material == b.material && a.background == b.background && a.clips == b.clips &&
           a.planes == b.planes && (a.planes.empty() || a.planes_window == b.planes_window) &&
           a.tint_gaps == b.tint_gaps && a.gap_color == b.gap_color &&
           std::ranges::equal(a.surfaces, b.surfaces, [](const Surface& p, const Surface& q) {
               return same_parameters(p, q);
           });
}

std::uint64_t History::add_line(const std::string& text, const std::string& subject) {
    is_full_ = is_full_ || lines_.size() == max_history_lines;
    if (!is_full_) {
        lines_.push_back({next_number_, text, subject});
    }
    return next_number_++;
}

void History::note(const Deed& deed, const Scene& before, const Scene& after) {
    const bool is_step = !same_parameters(before, after);
    const bool is_change = is_step || before.size != after.size ||
                           before.overlay != after.overlay || before.samples != after.samples ||
                           before.detail != after.detail || before.stereo != after.stereo;
    if (!deed.is_action && !is_change) {
        return;
    }
    const bool goes_on = !deed.subject.empty() && !is_marked_ && !lines_.empty() && !is_full_ &&
                         lines_.back().subject == deed.subject;
    if (goes_on) {
        lines_.back().text = deed.line;
    }
    const std::uint64_t number = goes_on ? lines_.back().number : add_line(deed.line, deed.subject);
    is_marked_ = false;
    if (!is_step) {
        return;
    }
    redo_.clear();
    if (goes_on && !undo_.empty() && undo_.back().number == number) {
        undo_.back().line = deed.line;
        return;
    }
    undo_.push_back({number, deed.line, deed.subject, before});
    if (undo_.size() > max_undo_steps) {
        undo_.pop_front();
        ++dropped_;
    }
}

void History::note_losses(const Scene& before, const Scene& after) {
    for (const Surface& surface : before.surfaces) {
        if (!has_surface(after, surface.name)) {
            add_line(to_line({"remove", {surface.name}, {}}), {});
        }
    }
    is_marked_ = true;
}

void History::drop_steps() {
    dropped_ += undo_.size();
    undo_.clear();
    redo_.clear();
}

void History::begin_anew(const std::string& load_line) {
    drop_steps();
    load_line_ = load_line;
    ++loads_;
}

void History::forget_load() {
    drop_steps();
    load_line_.reset();
    is_marked_ = true;
}

std::optional<std::string> History::undo_line() const {
    return undo_.empty() ? std::nullopt : std::optional(undo_.back().line);
}
std::optional<std::string> History::redo_line() const {
    return redo_.empty() ? std::nullopt : std::optional(redo_.back().line);
}

const Scene& History::before_last() const {
    if (undo_.empty()) {
        refuse_command("there is nothing to undo: nothing was changed since the last load");
    }
    return undo_.back().scene;
}

const Scene& History::after_next() const {
    if (redo_.empty()) {
        refuse_command("there is nothing to redo: nothing was undone since the last change");
    }
    return redo_.back().scene;
}

void History::undone(const Scene& current) {
    Step step = std::move(undo_.back());
    undo_.pop_back();
    if (!lines_.empty() && lines_.back().number == step.number) {
        lines_.pop_back();  // As if it had never been.
    } else {
        step.number = add_line(undo_word, {});  // Something has been done with it meanwhile.
    }
    step.scene = current;
    redo_.push_back(std::move(step));
    is_marked_ = true;
}

void History::redone(const Scene& current) {
    Step step = std::move(redo_.back());
    redo_.pop_back();
    if (!lines_.empty() && lines_.back().number == step.number) {
        lines_.pop_back();  // The word undo.
        step.number = next_number_++;
    } else {
        step.number = add_line(step.line, step.subject);
    }
    step.scene = current;
    undo_.push_back(std::move(step));
    is_marked_ = true;
}

std::string History::script() const {
    std::string text;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
        const bool splits =
            i > 0 && !lines_[i].subject.empty() && lines_[i].subject == lines_[i - 1].subject;
        text += (splits ? "mark\n" : "") + lines_[i].text + "\n";
    }
    if (is_full_) {
        text += fmt::format("# the session went on: only its first {} lines are kept\n",
                            max_history_lines);
    }
    return text;
}

}  // namespace pxpl5::host
