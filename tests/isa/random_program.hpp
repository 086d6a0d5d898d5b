// Valid random programs from a seed: every row reachable, fields that collide, enables that live.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "isa/executor.hpp"
#include "isa/program.hpp"

namespace pxpl5::test {

/// The seed of PXPL5_SEED, or `fallback`.
inline std::uint64_t seed_or(std::uint64_t fallback) {
    const char* text = std::getenv("PXPL5_SEED");
    return text == nullptr ? fallback : std::strtoull(text, nullptr, 0);
}

struct RandomProgramOptions {
    std::size_t instructions = 200;  ///< At least; a program may close loops behind them.
    bool flow = true;                ///< Emit CALL, RET, LOOP, SKIPIFNONE and EOR.
};

/// Makes one program per call of program(). The same seed gives the same programs everywhere: only
/// mt19937_64 is used, no distribution of the standard library.
class RandomPrograms {
  public:
    explicit RandomPrograms(std::uint64_t seed) : random_(seed) {}

    /// A program that passes check().
    std::vector<std::uint32_t> program(const RandomProgramOptions& options = {});

    /// Operands that check() accepts for `row`, control flow aside.
    isa::Operands operands(const isa::OpInfo& row);

    /// A coefficient: small, sparse, extreme or any.
    std::int32_t coefficient();

    /// 0 .. count-1.
    std::uint32_t below(std::uint32_t count) {
        return static_cast<std::uint32_t>(random_() % count);
    }

  private:
    struct Transfer {
        std::uint32_t field, block;
    };

    isa::Op row();
    void restore_enables();
    void noise();
    void pixel_instruction(const RandomProgramOptions& options);
    void emit(isa::Instruction in);
    void emit_flow(isa::Op op);
    void tree_coefficients(int count);
    void wait_if_touched(isa::Instruction in);
    void wait();
    void finish();

    std::mt19937_64 random_;
    std::vector<std::uint32_t> words_;
    std::size_t instructions_ = 0;
    std::vector<Transfer> open_;
    std::vector<std::size_t> loops_;            ///< Instruction counts at their heads.
    std::size_t skip_at_ = 0, skip_until_ = 0;  ///< Coefficient word of an open SKIPIFNONE.
    std::vector<std::size_t> calls_;            ///< Coefficient words of CALLs.
    std::vector<std::uint32_t> recent_;         ///< Addresses used of late, to collide with.
};

}  // namespace pxpl5::test
