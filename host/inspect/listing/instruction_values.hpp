// Describes the effect of one instruction on one pixel, from the values before and after it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "host/inspect/record/region_walk.hpp"
#include "isa/contract/region_layout.hpp"
#include "isa/executor.hpp"

namespace pxpl5::host::inspect {

/// "z", "rgb", or "m88:16" of a field that has no name (isa/region_layout.hpp).
std::string field_name(std::uint32_t address, std::uint32_t width);

/// The field that a name of isa/region_layout.hpp means; nothing if it is none.
std::optional<isa::region::Field> field_named(std::string_view name);

/// Reads an instruction's effect on a pixel: made before the instruction runs, asked behind it.
class InstructionValues {
  public:
    /// executor  Holds the pixels, before the instruction.
    InstructionValues(isa::Instruction in, isa::Coefficients coefficients, RegionPixel pixel,
                      const isa::Executor& executor);

    /// "z 16777215 -> 81920", "z 5 (pixel disabled)", "Q = -12, is disabled", "T = 7, z = 12, stays
    /// enabled"; empty for an instruction that neither writes nor tests. Q is the tree's value, T
    /// what a test makes of it.
    /// executor  Holds the pixels behind the instruction.
    std::string text(const isa::Executor& executor) const;

  private:
    std::uint64_t read(const isa::Executor& executor) const;
    std::string number(std::uint64_t value) const;
    std::string operand_text() const;

    isa::Instruction in_;
    const isa::OpInfo& row_;
    RegionPixel pixel_;
    std::uint32_t width_;  ///< Width of the field at a; 0 without a field.
    bool enabled_;
    std::uint64_t field_ = 0;
    std::optional<std::int64_t> form_;  ///< Q of a TREE or QUAD instruction.
};

/// A x + B y + C (+ D xx + E xy + F yy) of 3 or 6 coefficients.
std::int64_t form_of(isa::Coefficients coefficients, RegionPixel pixel);

}  // namespace pxpl5::host::inspect
