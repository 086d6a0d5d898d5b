// What viewers have asked for and has not been done yet.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "host/commands.hpp"

namespace pxpl5::host::serve {

inline constexpr std::size_t max_waiting = 1000;

/// A command, or a question whose answer is bytes.
struct Wish {
    std::uint32_t viewer = 0;
    std::optional<std::uint32_t> id;  ///< Nobody waits for an answer without one.
    bool is_ask = false;
    std::string text;     ///< The command line, or the whole `ask` message.
    Arguments arguments;  ///< Of the line.
};

/// In the order of arrival; but a setting takes the place of an older one of the same subject, if
/// nothing but settings and asks lies between: actions and commands that ask see what they would
/// have seen.
class Inbox {
  public:
    enum class Added : std::uint8_t { waits, full };
    struct Outcome {
        Added added = Added::waits;
        std::optional<Wish> superseded;  ///< Will not be done.
    };

    /// Throws RequestError if there is no such command.
    Outcome add(Wish wish);
    bool empty() const { return waiting_.empty(); }
    std::size_t size() const { return waiting_.size(); }
    /// The oldest; not on an empty one (asserted).
    Wish take();
    /// Forgets what a viewer who left has asked; what it has set is done.
    void forget_asks(std::uint32_t viewer);

  private:
    struct Entry {
        Wish wish;
        std::string subject;  ///< As subject_of().
        bool is_barrier = false;
    };
    std::deque<Entry> waiting_;
};

}  // namespace pxpl5::host::serve
