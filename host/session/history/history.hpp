// The commands of a session: a script that repeats them, and the steps of undo.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"

namespace pxpl5::host {

inline constexpr std::size_t max_undo_steps = 500;         ///< Older steps are dropped.
inline constexpr std::size_t max_history_lines = 100'000;  ///< Later lines are dropped.

/// A command that was done.
struct Deed {
    std::string line;        ///< In the form that parse_line() takes.
    std::string subject;     ///< See subject_of(); empty if the command is no setting.
    bool is_action = false;  ///< Belongs to the script even if the scene stays the same.
};

/// Whether undo would restore the same. Ignores size, overlay and detail of the picture and the
/// numbers of surfaces.
bool same_parameters(const Scene& a, const Scene& b);

/// Steps have parameters, but no pictures and no meshes. Consecutive settings of one subject are
/// one line and one step, so that one undo takes back a drag. mark() ends the step. No clock is
/// involved, so that the script has the same steps when it runs again.
class History {
  public:
    /// Adds a command; `before` and `after` are the scenes around it.
    void note(const Deed& deed, const Scene& before, const Scene& after);
    /// Adds a failed command, because the script must repeat its losses.
    void note_losses(const Scene& before, const Scene& after);
    /// Adds a load. Undo does not go back beyond it.
    void begin_anew(const std::string& load_line);
    /// Adds a failed load that removed the previous volume. Undo does not go back beyond it.
    void forget_load();
    void mark() { is_marked_ = true; }

    /// The line that undo or redo would act on, if any.
    std::optional<std::string> undo_line() const;
    std::optional<std::string> redo_line() const;
    /// Number of steps before now, dropped ones included; undone() lowers it by 1.
    std::uint64_t step() const { return dropped_ + undo_.size(); }
    /// The parameters to restore. Throw RequestError (usage) if no step exists.
    const Scene& before_last() const;
    const Scene& after_next() const;
    /// Confirms that they were restored; `current` is the scene before.
    void undone(const Scene& current);
    void redone(const Scene& current);

    /// Counts nested scripts that run.
    void begin_play() { ++plays_; }
    void end_play() { --plays_; }
    int plays() const { return plays_; }

    /// A script that repeats the session, a newline after each line.
    std::string script() const;
    /// The newest load, if any.
    const std::optional<std::string>& load_line() const { return load_line_; }
    int loads() const { return loads_; }  ///< Number of loads.

  private:
    struct Line {
        std::uint64_t number;
        std::string text, subject;
    };
    struct Step {
        std::uint64_t number;  ///< Number of the line.
        std::string line, subject;
        Scene scene;  ///< The scene to restore.
    };

    void drop_steps();
    std::uint64_t add_line(const std::string& text, const std::string& subject);

    std::vector<Line> lines_;
    std::uint64_t next_number_ = 1;
    bool is_full_ = false;
    bool is_marked_ = false;  ///< The next setting starts a step.
    std::deque<Step> undo_;
    std::vector<Step> redo_;
    std::uint64_t dropped_ = 0;  ///< Steps that undo cannot reach any more.
    std::optional<std::string> load_line_;
    int loads_ = 0;
    int plays_ = 0;
};

}  // namespace pxpl5::host
