// Sensitivity of the modelled figures: a table, words, a picture.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host/base/reply.hpp"
#include "host/chart/plot.hpp"
#include "host/timing/sensitivity.hpp"

namespace pxpl5::host::report {

/// names  Of the cases, in their order.
/// Parameters that change no figure by `least_shown_percent` are only named.
inline constexpr double least_shown_percent = 0.5;
std::string text_of(const std::vector<timing::Sensitivity>& list,
                    std::span<const std::string> names);

/// One for each parameter, value and case.
std::vector<Fields> fields_of(const std::vector<timing::Sensitivity>& list,
                              std::span<const std::string> names);

/// The mean change over all cases: of the time to build, of the frames/s. The greatest ten.
std::vector<Plot> plots_of(const std::vector<timing::Sensitivity>& list);

}  // namespace pxpl5::host::report
