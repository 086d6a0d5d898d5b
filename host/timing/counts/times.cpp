#include "host/timing/counts/times.hpp"

#include <algorithm>
#include <array>

namespace pxpl5::host::timing {

std::string_view name_of(Unit unit) {
    static constexpr std::array<std::string_view, 7> names = {
        "host", "host link", "GP", "ring", "Renderer", "frame buffer", "waiting"};
    return names.at(static_cast<std::size_t>(unit));
}

const UnitUse& busiest_of(const std::vector<UnitUse>& use) {
    return *std::ranges::max_element(use, {}, &UnitUse::busiest);
}

Unit limit_of(const std::vector<UnitUse>& use) {
    const UnitUse& most = busiest_of(use);
    return most.busiest < least_limit_share ? Unit::waiting : most.unit;
}

}  // namespace pxpl5::host::timing
