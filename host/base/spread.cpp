#include "host/base/spread.hpp"

#include <algorithm>
#include <cstddef>

namespace pxpl5::host {

namespace {

/// The least value that `percent` of the ascending values do not exceed.
double at_rank(const std::vector<double>& ascending, std::size_t percent) {
    return ascending[(ascending.size() * percent + 99) / 100 - 1];
}

}  // namespace

Spread spread_of(std::vector<double> values) {
    if (values.empty()) {
        return {};
    }
    std::ranges::sort(values);
    return {at_rank(values, 50), at_rank(values, 95), values.back()};
}

}  // namespace pxpl5::host
