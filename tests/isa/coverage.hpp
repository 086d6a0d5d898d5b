// Records which widths, enables and edges of the region the instructions have met.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "isa/executor.hpp"

namespace pxpl5::test {

/// The enabled pixels when an instruction runs.
enum class Enables : std::uint8_t {
    none,
    inside,  ///< Some pixels, none at the edge of the region (x or y is 0 or 127).
    edge,    ///< Some pixels, including some at the edge.
    all,
};

Enables enables_of(const isa::Executor& executor);

/// Classes of width n. A row without n has only class 0.
inline constexpr std::array<std::string_view, 5> width_names = {"1", "2..8", "9..16", "17..32",
                                                                "33..64"};
std::size_t width_class(std::uint32_t n);
std::size_t width_classes(const isa::OpInfo& row);  ///< Number of classes of the row.

/// The cells that were met: row x width class x enables.
struct Coverage {
    std::array<std::array<std::uint8_t, width_names.size()>, isa::op_count> met{};

    void note(isa::Instruction in, Enables enables) {
        met[static_cast<std::size_t>(in.op)][width_class(in.operands.n)] |=
            static_cast<std::uint8_t>(1U << static_cast<unsigned>(enables));
    }
    bool has(std::size_t row, std::size_t width, Enables enables) const {
        return (met[row][width] >> static_cast<unsigned>(enables) & 1) != 0;
    }
    std::size_t cells() const;  ///< Number of cells that were met.
};

std::size_t possible_cells();

/// Returns the possible cells that were not met, such as "MEMltMEM, width 9..16, all".
std::vector<std::string> open_cells(const Coverage& coverage);

/// Returns the cells of the conformance cases. Throws isa::ConformanceError.
Coverage coverage_of_suite();

/// Returns the report: suite beside phantoms.
std::string coverage_markdown(const Coverage& suite, const Coverage& phantoms);

}  // namespace pxpl5::test
