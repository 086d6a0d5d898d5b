// Which instruction has met which width, enables and edges of the region.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "isa/executor.hpp"

namespace pxpl5::test {

/// Which pixels are enabled when an instruction runs.
enum class Enables : std::uint8_t {
    none,
    inside,  ///< Some, none of which lies at the region's edge (x or y is 0 or 127).
    edge,    ///< Some, at the edge too.
    all,
};

Enables enables_of(const isa::Executor& executor);

/// Classes of width n; a row without n has the one class 0.
inline constexpr std::array<std::string_view, 5> width_names = {"1", "2..8", "9..16", "17..32",
                                                                "33..64"};
std::size_t width_class(std::uint32_t n);
std::size_t width_classes(const isa::OpInfo& row);  ///< How many the row has.

/// Cells that were met: row x width class x enables.
struct Coverage {
    std::array<std::array<std::uint8_t, width_names.size()>, isa::op_count> met{};

    void note(isa::Instruction in, Enables enables) {
        met[static_cast<std::size_t>(in.op)][width_class(in.operands.n)] |=
            static_cast<std::uint8_t>(1U << static_cast<unsigned>(enables));
    }
    bool has(std::size_t row, std::size_t width, Enables enables) const {
        return (met[row][width] >> static_cast<unsigned>(enables) & 1) != 0;
    }
    std::size_t cells() const;  ///< How many were met.
};

std::size_t possible_cells();

/// Cells that can be met and were not, as "MEMltMEM, width 9..16, all".
std::vector<std::string> open_cells(const Coverage& coverage);

/// What the conformance cases meet. Throws isa::ConformanceError.
Coverage coverage_of_suite();

/// The report: suite beside phantoms.
std::string coverage_markdown(const Coverage& suite, const Coverage& phantoms);

}  // namespace pxpl5::test
