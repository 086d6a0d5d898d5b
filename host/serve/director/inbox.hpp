// The viewers' commands and questions that wait.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>

#include "host/commands/commands.hpp"

namespace pxpl5::host::serve {

inline constexpr std::size_t max_waiting = 1000;        ///< Limit of commands.
inline constexpr std::size_t max_asks_of_a_viewer = 8;  ///< Questions of different kinds.

/// A command, or a question whose answer is bytes.
struct Wish {
    std::uint32_t viewer = 0;
    std::optional<std::uint32_t> id;  ///< Empty: the viewer needs no reply.
    bool is_ask = false;
    std::string text;       ///< The command line, or the whole `ask` message.
    Arguments arguments;    ///< Words of the command line.
    std::string kind = {};  ///< Kind of a question. A newer question of this kind replaces it.
};

/// Gives commands before questions, both in the order of arrival. A setting replaces an older
/// setting of the same subject if only settings lie between them, so that actions and questions see
/// the same scene. A question replaces the viewer's older question of the same kind, at its place.
class Inbox {
  public:
    enum class Added : std::uint8_t { waits, full };
    struct Outcome {
        Added added = Added::waits;
        std::optional<Wish> superseded;  ///< The replaced command or question.
    };

    /// Throws RequestError if the command does not exist.
    Outcome add(Wish wish);
    bool empty() const { return commands_.empty() && asks_.empty(); }
    bool has_command() const { return !commands_.empty(); }
    /// Whether a command waits that may change the picture.
    bool changes_picture() const;
    std::size_t size() const { return commands_.size() + asks_.size(); }
    /// The oldest command, or else the oldest question. The inbox must not be empty (asserted).
    Wish take();
    /// The oldest question whose kind begins so, if any.
    std::optional<Wish> take_ask(std::string_view kind);
    /// Drops the questions of a viewer that left. Its commands stay.
    void forget_asks(std::uint32_t viewer);

  private:
    struct Command {
        Wish wish;
        std::string subject;  ///< See subject_of(); empty: no newer command replaces older ones.
        std::string thing;    ///< The surface or light that is set; empty: the scene.
        bool changes_picture = false;
    };
    Outcome add_command(Wish wish);
    Outcome add_ask(Wish wish);
    std::optional<Wish> supersede(const Command& newer);

    std::deque<Command> commands_;
    std::deque<Wish> asks_;
};

}  // namespace pxpl5::host::serve
