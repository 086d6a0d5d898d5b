// Reduces a program that shows something to the fewest instructions that still show it.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "host/inspect/diff/diff.hpp"

namespace pxpl5::host::inspect {

/// True if the program, which has passed isa::check(), still shows it.
using Shows = std::function<bool(std::span<const std::uint32_t>)>;

struct Shrunk {
    std::vector<std::uint32_t> words;
    std::size_t instructions = 0, instructions_before = 0;
    std::size_t tried = 0;  ///< Programs that were run.
};

/// Drops primitives, then instructions, then simplifies coefficients and operands, until nothing
/// more can be taken away by itself. Jumps follow their targets.
///
/// words  A checked program that shows it.
/// Throws RequestError (failed) if it does not.
Shrunk shrink(std::span<const std::uint32_t> words, const Shows& shows);

/// Shown if the executors leave a pixel differently, its readout included.
Shows differ_at(RegionPixel pixel, const NamedExecutor& trusted, const NamedExecutor& other);

/// Shown if field m[a : a+n) of a pixel holds `value` in the end.
struct FieldValue64 {
    std::uint32_t a = 0, n = 1;
    std::uint64_t value = 0;
};
Shows holds_at(RegionPixel pixel, const FieldValue64& field, const NamedExecutor& executor);

/// The programs of a region as one, up to and with what `last` names; all of them if it is null.
/// EORs are left out.
/// Throws RequestError (failed) if a program stops in its midst.
std::vector<std::uint32_t> whole_program(const renderer::RegionPlan& plan,
                                         const Divergence* last = nullptr);

/// A program by itself, as a region with one part. `words` outlive it.
renderer::RegionPlan plan_of_program(std::span<const std::uint32_t> words);

/// Describes a shrunk program.
struct ShrunkStory {
    std::string title;  ///< One sentence, for a test's name; neither quotes nor backslashes.
    std::string from;   ///< Where it came from.
    RegionPixel pixel;
};

/// The program as a file for `asm`, `exec` and `trace shrink`.
std::string as_assembly(const Shrunk& shrunk, const ShrunkStory& story);
/// A doctest case for tests/renderer_firmware: both executors leave the same.
std::string as_doctest(const Shrunk& shrunk, const ShrunkStory& story);
/// A case of the conformance suite: what the reference leaves in the pixel.
std::string as_conformance(const Shrunk& shrunk, const ShrunkStory& story);

}  // namespace pxpl5::host::inspect
