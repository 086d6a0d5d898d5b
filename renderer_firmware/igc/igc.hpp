// The image generation controller: checks a stream, runs it on an executor, counts instructions.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "isa/instruction_counts.hpp"
#include "isa/program.hpp"
#include "isa/sequencer.hpp"

namespace pxpl5::renderer {

struct Outcome {
    isa::RunCounts counts;  ///< Counts of the executed part; 0 if the check failed.
    std::optional<isa::ProgramError> error;  ///< Why the program did not run, or not to its end.
};

class Igc {
  public:
    /// `executor` must outlive the controller.
    explicit Igc(isa::Executor& executor) : executor_(executor) {}

    /// Returns the error of `words`, if any. Skips the check if `words` are only triangles.
    static std::optional<isa::ProgramError> check(std::span<const std::uint32_t> words);

    /// Runs `words`, which must have passed check(), to their end.
    Outcome run_checked(std::span<const std::uint32_t> words);

    /// Like run_checked(), and adds the executed instructions to `executed`. Slower.
    Outcome run_counted(std::span<const std::uint32_t> words, isa::InstructionCounts& executed);

    /// Checks `words` and runs them to their end. Runs nothing if the check fails.
    Outcome run(std::span<const std::uint32_t> words);

  private:
    template <typename Run>
    Outcome run_to_end(std::span<const std::uint32_t> words, const Run& run);

    isa::Executor& executor_;
    isa::Controller controller_;
};

/// True if `words` consist of triangle programs only (isa/contract/triangle_shape.hpp). These need
/// no check.
bool only_triangles(std::span<const std::uint32_t> words);

}  // namespace pxpl5::renderer
