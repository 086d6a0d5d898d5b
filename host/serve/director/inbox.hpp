// What viewers have asked for and has not been done yet.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "host/commands/commands.hpp"

namespace pxpl5::host::serve {

inline constexpr std::size_t max_waiting = 1000;        ///< Commands.
inline constexpr std::size_t max_asks_of_a_viewer = 8;  ///< Each of another kind.

/// A command, or a question whose answer is bytes.
struct Wish {
    std::uint32_t viewer = 0;
    std::optional<std::uint32_t> id;  ///< Nobody waits for an answer without one.
    bool is_ask = false;
    std::string text;       ///< The command line, or the whole `ask` message.
    Arguments arguments;    ///< Of the line.
    std::string kind = {};  ///< Of an ask: a viewer needs the newest answer of each kind.
};

/// Commands before asks, both in the order of arrival. A setting makes an older one of the same
/// subject superfluous, if nothing but settings lies between: actions and commands that ask see
/// what they would have seen. Of asks only the newest of a viewer and kind is left, in the place of
/// the older.
class Inbox {
  public:
    enum class Added : std::uint8_t { waits, full };
    struct Outcome {
        Added added = Added::waits;
        std::optional<Wish> superseded;  ///< Will not be done.
    };

    /// Throws RequestError if there is no such command.
    Outcome add(Wish wish);
    bool empty() const { return commands_.empty() && asks_.empty(); }
    bool has_command() const { return !commands_.empty(); }
    /// Whether a command waits that may change what is shown.
    bool changes_picture() const;
    std::size_t size() const { return commands_.size() + asks_.size(); }
    /// The oldest command, or else the oldest ask; not on an empty one (asserted).
    Wish take();
    /// Forgets what a viewer who left has asked; what it has set is done.
    void forget_asks(std::uint32_t viewer);

  private:
    struct Command {
        Wish wish;
        std::string subject;  ///< As subject_of(); empty: what is before must be done before.
        std::string thing;    ///< Whose setting it is, as a surface; empty: the scene's.
        bool changes_picture = false;
    };
    Outcome add_command(Wish wish);
    Outcome add_ask(Wish wish);
    std::optional<Wish> supersede(const Command& newer);

    std::deque<Command> commands_;
    std::deque<Wish> asks_;
};

}  // namespace pxpl5::host::serve
