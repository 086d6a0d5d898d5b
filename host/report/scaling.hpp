// How the modelled machine does with more GPs and more Renderers, and where that stops to help.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/base/reply.hpp"
#include "host/chart/plot.hpp"
#include "host/timing/counts/machine.hpp"
#include "host/timing/paper_case.hpp"
#include "host/timing/simulate.hpp"

namespace pxpl5::host::report {

struct ScalingPoint {
    std::uint32_t count = 0;  ///< Number of the nodes that grow.
    double build_ms = 0, frames_per_s = 0;
    timing::Unit build_limit{}, frames_limit{};
};

/// One surface on machines that differ in one count, which doubles from point to point.
struct ScalingSeries {
    std::vector<ScalingPoint> points;

    /// Times as fast as the first.
    std::vector<double> build_speed_up() const;
    std::vector<double> frames_speed_up() const;
};

struct ScalingRow {
    std::string name;
    ScalingSeries gps, renderers;
};

struct ScalingReport {
    std::uint32_t gps = 0, renderers = 0;  ///< The count that stays while the other grows.
    std::vector<ScalingRow> rows;
};

/// Doubling that gains less does not help.
inline constexpr double least_gain = 0.05;

/// Index of the first point from which doubling gains less than `least_gain`; none if doubling
/// helps up to the last.
std::optional<std::size_t> saturation(std::span<const double> speed_up);

/// 1, 2, 4 .. 64 GPs, and as many Renderers, the machine being otherwise as it is.
ScalingRow scaling_of(const timing::Machine& machine, const std::string& name,
                      const timing::PaperCase& work);

/// Tables, each followed by what they say in words.
std::string text_of(const ScalingReport& report);
/// One for each point.
std::vector<Fields> fields_of(const ScalingReport& report);
/// Frames/s and build by GPs, frames/s by Renderers.
std::vector<Plot> plots_of(const ScalingReport& report);

}  // namespace pxpl5::host::report
