// The controller: runs a checked program. The sequencer runs the control rows, and an Executor
// runs all other rows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "isa/executor.hpp"
#include "isa/program.hpp"

namespace pxpl5::isa {

/// The instructions that loops and calls may add to one run. The slowest ones take 24 us on the
/// fast executor (QUADclampintoMEM of 32 bits), so that a crafted stream ends within two minutes,
/// before the heartbeat's stuck_s. Programs that people write repeat some thousands.
inline constexpr std::uint64_t max_repeated_instructions = std::uint64_t{1} << 22;

/// The most instructions of a run of `words` words. A program without loops and calls executes at
/// most one instruction per word, so that it ends below the limit however long it is.
constexpr std::uint64_t usual_step_limit(std::size_t words) {
    return words + max_repeated_instructions;
}

/// Thrown when a run cannot continue: step limit reached, CALL or LOOP too deep, RET without CALL.
/// The text names the word offset and the limit.
struct RunError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// The state of the controller that lasts from stream to stream.
struct Controller {
    bool flag = true;                         ///< Result of the last ANYENAB. Initially 1: no skip.
    std::optional<std::uint64_t> step_limit;  ///< Instructions of one run, else the usual limit.
    std::function<void(std::uint32_t)> on_signal;  ///< Called with the number of each SIGNAL.
};

struct RunCounts {
    std::uint64_t instructions = 0;
    std::uint64_t cycles = 0;  ///< Modelled, 40 MHz.
};

/// Runs one program once, step by step or to its end.
class Sequencer {
  public:
    /// `words` must have passed check(). All arguments must outlive the sequencer.
    Sequencer(std::span<const std::uint32_t> words, Executor& executor, Controller& controller)
        : words_(words), executor_(executor), controller_(controller) {}

    bool done() const { return state_.at >= words_.size(); }
    std::size_t at() const { return state_.at; }  ///< Word offset of the next instruction.
    const RunCounts& counts() const { return state_.counts; }

    struct OpenLoop {
        std::size_t body;    ///< Word offset after the LOOP.
        std::uint32_t left;  ///< Remaining rounds, including the current one.
    };
    /// The progress of a run, without the executor's pixels and the controller's flag.
    struct State {
        std::size_t at = 0;
        std::vector<std::size_t> returns;
        std::vector<OpenLoop> loops;
        RunCounts counts;
    };
    const State& state() const { return state_; }
    /// Continues from a saved state of a run of the same words.
    void restore(State state) { state_ = std::move(state); }

    /// Runs one instruction; the run must not be done(). Throws RunError.
    void step();

    /// Runs to the end, and lets the executor run ahead. Throws RunError.
    const RunCounts& run();

  private:
    void control(Instruction in, std::span<const std::uint32_t> coefficients);
    void open_loop(std::uint32_t rounds);
    void close_loop();
    void call(std::size_t target);
    void return_from_call();
    void signal(std::uint32_t number);
    void count(std::uint64_t instructions, std::uint64_t cycles);
    std::size_t behind_matching_end_loop() const;

    std::span<const std::uint32_t> words_;
    Executor& executor_;
    Controller& controller_;
    State state_;
};

/// Runs checked `words` on `executor` to the end. Throws RunError.
RunCounts run(std::span<const std::uint32_t> words, Executor& executor, Controller& controller);

}  // namespace pxpl5::isa
