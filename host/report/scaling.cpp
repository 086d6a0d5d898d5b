#include "host/report/scaling.hpp"

#include <algorithm>
#include <functional>

namespace pxpl5::host::report {

namespace {

constexpr std::uint32_t most_nodes = 64;

ScalingSeries series_of(timing::Machine machine, std::uint32_t timing::Machine::*count,
                        const timing::PaperCase& work) {
    ScalingSeries series;
    for (std::uint32_t nodes = 1; nodes <= most_nodes; nodes *= 2) {
        machine.*count = nodes;
        const timing::CaseTime time = timing::time_of(machine, work);
        series.points.push_back(
            {nodes, time.built_ms, time.rate.frames_per_s, time.build.limit, time.rate.limit});
    }
    return series;
}

}  // namespace

std::vector<double> ScalingSeries::build_speed_up() const {
    std::vector<double> factors;
    for (const ScalingPoint& point : points) {
        factors.push_back(points.front().build_ms / point.build_ms);
    }
    return factors;
}

std::vector<double> ScalingSeries::frames_speed_up() const {
    std::vector<double> factors;
    for (const ScalingPoint& point : points) {
        factors.push_back(point.frames_per_s / points.front().frames_per_s);
    }
    return factors;
}

std::optional<std::size_t> saturation(std::span<const double> speed_up) {
    const auto gains_little = [](double before, double after) {
        return after < before * (1 + least_gain);
    };
    const auto found = std::ranges::adjacent_find(speed_up, gains_little);
    if (found == speed_up.end()) {
        return std::nullopt;
    }
    return static_cast<std::size_t>(found - speed_up.begin());
}

ScalingRow scaling_of(const timing::Machine& machine, const std::string& name,
                      const timing::PaperCase& work) {
    return {name, series_of(machine, &timing::Machine::gps, work),
            series_of(machine, &timing::Machine::renderers, work)};
}

}  // namespace pxpl5::host::report
