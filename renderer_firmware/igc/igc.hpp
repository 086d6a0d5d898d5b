// The image generation controller: checks a stream, runs it on an executor, counts.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "isa/instruction_counts.hpp"
#include "isa/program.hpp"
#include "isa/sequencer.hpp"

namespace pxpl5::renderer {

struct Outcome {
    isa::RunCounts counts;                   ///< Of what ran; zero if the check failed.
    std::optional<isa::ProgramError> error;  ///< Why nothing, or not everything, ran.
};

class Igc {
  public:
    /// `executor` outlives the controller.
    explicit Igc(isa::Executor& executor) : executor_(executor) {}

    /// What is wrong with `words`, if anything. Nothing but triangles needs no walk through them.
    static std::optional<isa::ProgramError> check(std::span<const std::uint32_t> words);

    /// Runs `words`, which have passed check(), to their end.
    Outcome run_checked(std::span<const std::uint32_t> words);

    /// As run_checked(), and adds what was executed to `executed`: for one who counts, slower.
    Outcome run_counted(std::span<const std::uint32_t> words, isa::InstructionCounts& executed);

    /// Checks `words` and, if they are a program, runs them to their end. Nothing runs otherwise.
    Outcome run(std::span<const std::uint32_t> words);

  private:
    template <typename Run>
    Outcome run_to_end(std::span<const std::uint32_t> words, const Run& run);

    isa::Executor& executor_;
    isa::Controller controller_;
};

/// True if `words` is nothing but triangle programs (isa/contract/triangle_shape.hpp): these need
/// no check.
bool only_triangles(std::span<const std::uint32_t> words);

}  // namespace pxpl5::renderer
