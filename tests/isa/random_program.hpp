// Valid random programs from a seed: all rows, overlapping fields, changing enables.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "isa/executor.hpp"
#include "isa/program.hpp"

namespace pxpl5::test {

struct RandomProgramOptions {
    std::size_t instructions = 200;  ///< Minimum; closing loops adds more.
    bool flow = true;                ///< Emit CALL, RET, LOOP, SKIPIFNONE and EOR.
};

/// Makes one program per call of program(). The same seed gives the same programs on all computers,
/// because the class uses mt19937_64 without a distribution of the standard library.
class RandomPrograms {
  public:
    explicit RandomPrograms(std::uint64_t seed) : random_(seed) {}

    /// Returns a program that passes check().
    std::vector<std::uint32_t> program(const RandomProgramOptions& options = {});

    /// Returns operands of `row` that pass check(), apart from control flow.
    isa::Operands operands(const isa::OpInfo& row);

    /// Returns a coefficient: small, sparse, extreme or any.
    std::int32_t coefficient();

    /// Returns 0 .. count-1.
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
    std::vector<std::uint32_t> recent_;         ///< Recent addresses, for overlapping fields.
};

}  // namespace pxpl5::test
