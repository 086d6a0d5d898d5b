// What was done in a session: a script that repeats it, and the steps that can be taken back.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"

namespace pxpl5::host {

inline constexpr std::size_t max_undo_steps = 500;         ///< Older ones are forgotten.
inline constexpr std::size_t max_history_lines = 100'000;  ///< Later ones are not kept.

/// A command that was done.
struct Deed {
    std::string line;        ///< In the form that parse_line() takes.
    std::string subject;     ///< See subject_of(); empty if the command is no setting.
    bool is_action = false;  ///< Worth keeping even if it leaves the scene as it was.
};

/// Whether what undo restores is the same in both: all but size and overlay of the picture, and
/// what only numbers surfaces.
bool same_parameters(const Scene& a, const Scene& b);

/// Steps hold parameters, never pictures or meshes. Settings of one subject in a row are one line
/// and one step, so that a drag is taken back at once; mark() ends it. No clock decides that: the
/// script, run again, has the same steps.
class History {
  public:
    /// After a command: `before` and `after` are the scene then.
    void note(const Deed& deed, const Scene& before, const Scene& after);
    /// After a command that failed: what it lost all the same is lost in the script, too.
    void note_losses(const Scene& before, const Scene& after);
    /// After a load: nothing before it can be taken back.
    void begin_anew(const std::string& load_line);
    /// After a load that left nothing of the volume before it: no step leads back to it.
    void forget_load();
    void mark() { is_marked_ = true; }

    /// The line that undo or redo would act on; nothing if there is none.
    std::optional<std::string> undo_line() const;
    std::optional<std::string> redo_line() const;
    /// The parameters to restore. Throw RequestError (usage) if there is nothing.
    const Scene& before_last() const;
    const Scene& after_next() const;
    /// That has been done; `current` is the scene before it.
    void undone(const Scene& current);
    void redone(const Scene& current);

    /// Counts the scripts that are being played, one by the other.
    void begin_play() { ++plays_; }
    void end_play() { --plays_; }
    int plays() const { return plays_; }

    /// A script that repeats the session, a newline after each line.
    std::string script() const;
    /// The newest load, if there was one.
    const std::optional<std::string>& load_line() const { return load_line_; }
    int loads() const { return loads_; }  ///< So many there were.

  private:
    struct Line {
        std::uint64_t number;
        std::string text, subject;
    };
    struct Step {
        std::uint64_t number;  ///< Number of its line.
        std::string line, subject;
        Scene scene;  ///< To restore.
    };

    std::uint64_t add_line(const std::string& text, const std::string& subject);

    std::vector<Line> lines_;
    std::uint64_t next_number_ = 1;
    bool is_full_ = false;
    bool is_marked_ = false;  ///< The next setting begins a step.
    std::deque<Step> undo_;
    std::vector<Step> redo_;
    std::optional<std::string> load_line_;
    int loads_ = 0;
    int plays_ = 0;
};

}  // namespace pxpl5::host
