// What the model's texts and fields of runs and of sweeps have in common.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "host/base/chart_axis.hpp"
#include "host/base/reply.hpp"
#include "host/base/text_table.hpp"
#include "host/timing/simulate.hpp"

namespace pxpl5::host::inspect {

constexpr double ms(timing::Ns time) {
    constexpr double ns_per_ms = 1e6;
    return static_cast<double>(time) / ns_per_ms;
}

/// "frame 3"; of several samples "frames 3..6, 4 samples". `word` is "frame" or "Frame".
std::string picture_text(std::string_view word, std::uint32_t first, std::uint32_t samples);

/// Columns for what add_use() adds: the limit, and how busy the busiest of each kind was.
void add_use_headings(TableRow& heading);
void add_use(TableRow& row, timing::Unit limit, const std::vector<timing::UnitUse>& use);
std::vector<Fields> use_fields(const std::vector<timing::UnitUse>& use);

/// "paper-1993: 36 GPs at 40 MHz, 16 Renderers at 40 MHz, ..."
std::string machine_text(const Topology& plan);
Fields machine_fields(const Topology& plan);

/// A line for each sentence.
std::string missing_text(const std::vector<std::string>& missing);
std::vector<Fields> missing_fields(const std::vector<std::string>& missing);

}  // namespace pxpl5::host::inspect
