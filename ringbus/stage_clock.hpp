// Measures a node's time by stage. The node itself names its stages.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace pxpl5::bus {

/// Stages of one node.
inline constexpr std::size_t max_stages = 16;

/// Stages of every node. Further stages of a node are in its node.hpp.
namespace stage {
inline constexpr std::string_view wait = "wait";        ///< Waits for messages or credit.
inline constexpr std::string_view receive = "receive";  ///< Takes and verifies messages.
inline constexpr std::string_view send = "send";
inline constexpr std::string_view work = "work";  ///< All other work.
}  // namespace stage

/// A stage ends when another begins, so that the stages add up to the node's time. A change reads
/// the clock once (20 ns). So a stage is a whole piece of work, never a triangle.
class StageClock {
  public:
    struct Stage {
        std::string_view name;
        std::uint64_t ns = 0;
        std::uint64_t count = 0;  ///< Number of times that the stage began.
    };

    /// Begins in stage::wait.
    StageClock();

    /// Enters stage `name`, a string literal. Does nothing if that stage is current.
    void enter(std::string_view name);
    /// Moves `ns` of stage `from`, which has begun, to stage `to`.
    void move(std::string_view from, std::string_view to, std::uint64_t ns);

    /// All stages that have begun, up to now. The first is stage::wait.
    const std::vector<Stage>& stages();
    std::string_view current() const { return stages_[current_].name; }

    /// Enters a stage for its lifetime, then returns to the stage before.
    class In {
      public:
        /// clock  Null for a node that is not timed.
        In(StageClock* clock, std::string_view name)
            : clock_(clock), before_(clock == nullptr ? name : clock->current()) {
            enter(name);
        }
        ~In() { enter(before_); }
        In(const In&) = delete;
        In& operator=(const In&) = delete;
        void enter(std::string_view name) const {
            if (clock_ != nullptr) {
                clock_->enter(name);
            }
        }

      private:
        StageClock* clock_;
        std::string_view before_;
    };

  private:
    using Clock = std::chrono::steady_clock;

    void count_time();
    std::size_t index_of(std::string_view name);

    std::vector<Stage> stages_;
    std::size_t current_ = 0;
    Clock::time_point since_;
};

}  // namespace pxpl5::bus
