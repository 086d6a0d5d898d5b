// Axes of charts: round ticks, and numbers as people write them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace pxpl5::host {

/// One axis of a chart. Values below `low` are shown at `low`.
struct ChartAxis {
    double low = 0, high = 1;  ///< Shown at its two ends; low < high.
    bool logarithmic = false;  ///< Then low > 0.
    std::vector<double> ticks;

    /// Where the axis shows `value`: 0 at `low`, 1 at `high`; outside of both, the nearer.
    double place(double value) const;
};

/// From `low` to `high` exactly, with ticks at multiples of 1, 2 or 5 times a power of ten, at most
/// `most_ticks`.
ChartAxis linear_axis(double low, double high, int most_ticks);

/// From 0 to a round number not below `highest`, which its last tick is.
ChartAxis axis_from_zero(double highest, int most_ticks);

/// From a little below `lowest` to a little above `highest`, a decade apart or more, with ticks at
/// powers of ten, at most `most_ticks`. Both > 0.
ChartAxis logarithmic_axis(double lowest, double highest, int most_ticks);

/// From the power of two not above `lowest` to that not below `highest`, an octave apart or more,
/// with ticks at powers of two, at most `most_ticks`. Both > 0.
ChartAxis octave_axis(double lowest, double highest, int most_ticks);

/// The number with thousands apart, as "1,234,500" or "0.25"; at most six digits of a fraction.
std::string grouped(double value);

/// "1 GP", "1,200 GPs".
std::string counted(std::uint64_t n, std::string_view word);

}  // namespace pxpl5::host
