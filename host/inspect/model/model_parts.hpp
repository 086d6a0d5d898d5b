// The common parts of the answers about modelled runs and sweeps.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "host/base/answer.hpp"
#include "host/timing/simulate.hpp"

namespace pxpl5::host::inspect {

constexpr double ms(timing::Ns time) {
    constexpr double ns_per_ms = 1e6;
    return static_cast<double>(time) / ns_per_ms;
}

/// "frame 3"; "frames 3..6, 4 samples" for several samples. `word` is "frame" or "Frame".
std::string picture_text(std::string_view word, std::uint32_t first, std::uint32_t samples);

/// Adds the columns of add_use(): the limit, and how busy the busiest unit of each kind was.
void add_use_columns(Table& table);
void add_use(std::vector<Cell>& row, timing::Unit limit, const std::vector<timing::UnitUse>& use);
std::vector<Fields> use_fields(const std::vector<timing::UnitUse>& use);

/// Why more GPs do not load faster.
inline constexpr const char* load_note =
    "load: the host sends each slice to all GPs whose slabs need it. More GPs share the gradients, "
    "but up to 4 GPs, each adds a copy of the volume on the host's link.";

/// The machine, the commands' work that could not be counted, and what the percentages mean.
Answer machine_answer(const Topology& plan, const std::vector<std::string>& missing);

}  // namespace pxpl5::host::inspect
