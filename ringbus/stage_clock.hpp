// Where a node's time goes: counted by the node itself, in one stage at a time.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace pxpl5::bus {

/// Of one node; more is a bug of ours.
inline constexpr std::size_t max_stages = 16;

/// Stages of every node. What a node tells apart itself is named in its node.hpp.
namespace stage {
inline constexpr std::string_view wait = "wait";        ///< For messages or credit.
inline constexpr std::string_view receive = "receive";  ///< Takes messages, and verifies them.
inline constexpr std::string_view send = "send";
inline constexpr std::string_view work = "work";  ///< All that the node does not tell apart.
}  // namespace stage

/// Its time is the sum over its stages: each ends when another begins. A change of stages costs
/// one look at the clock (20 ns), so stages are whole pieces of work, never triangles.
class StageClock {
  public:
    struct Stage {
        std::string_view name;
        std::uint64_t ns = 0;
        std::uint64_t count = 0;  ///< How often it began.
    };

    /// Begins in stage::wait.
    StageClock();

    /// From here on, time is that of stage `name`, a literal. Does nothing if it is already.
    void enter(std::string_view name);
    /// `ns` of the time of stage `from`, which has begun, was spent in stage `to`.
    void move(std::string_view from, std::string_view to, std::uint64_t ns);

    /// All that have begun, counted up to now. wait is the first.
    const std::vector<Stage>& stages();
    std::string_view current() const { return stages_[current_].name; }

    /// A stage that lasts as long as this does; then the one before goes on.
    class In {
      public:
        /// clock  Null for nodes that are not timed.
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
