// How a handful of durations spread, for reports.
#pragma once

#include <vector>

namespace pxpl5::host {

/// By nearest rank: each is one of the values.
struct Spread {
    double median = 0, p95 = 0, max = 0;
};

/// All 0 if there are no values.
Spread spread_of(std::vector<double> values);

}  // namespace pxpl5::host
