// How a machine of today does on 1 to 256 computers, where that stops to help, and what would help.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/base/reply.hpp"
#include "host/chart/plot.hpp"
#include "host/machine/topology.hpp"
#include "host/timing/cluster/predict.hpp"
#include "host/timing/paper_case.hpp"

namespace pxpl5::host::report {

/// Frames per second, or new isovalues per second until their pictures are there.
struct ClusterRate {
    double per_s = 0;
    timing::ClusterUnit limit{};
};

struct ClusterPoint {
    std::uint32_t computers = 0;
    ClusterRate frames, thresholds;
    double network_mb = 0;  ///< A frame's messages between computers.
};

/// One surface on machines whose number of computers doubles from point to point.
struct ClusterSeries {
    std::vector<ClusterPoint> points;
    timing::Lever frames_lever, thresholds_lever;  ///< Where the rate no longer grows.

    /// Relative to the first point.
    std::vector<double> relative(ClusterRate ClusterPoint::*rate) const;
};

struct ClusterScalingRow {
    std::string name;
    ClusterSeries strong;  ///< The same volume and picture.
    ClusterSeries weak;    ///< Slabs grow with the computers; the same picture.
};

struct ClusterScaling {
    timing::Cluster cluster;
    std::uint32_t gps = 0, renderers = 0;  ///< On each computer.
    std::vector<ClusterScalingRow> rows;
};

/// The nodes of each kind on a computer: half its cores, at least 1.
std::uint32_t nodes_per_computer(const timing::Cluster& cluster);
/// The nodes of each kind on so many computers, at most max_modelled_nodes.
std::uint32_t nodes_on(std::uint32_t computers, std::uint32_t per_computer);

/// Index of the point from which more computers no longer help: strong, see saturation(); weak, the
/// last point with at least half the rate of one computer. None: they help up to the last.
std::optional<std::size_t> end_of_growth(const std::vector<double>& relative, bool is_weak);

/// 1, 2, 4 .. 256 computers. `topology` has the placement.
ClusterScalingRow cluster_scaling_of(const Topology& topology, const timing::Cluster& cluster,
                                     const std::string& name, const timing::PaperCase& work);

/// The parameters, then tables, each followed by what they say in words.
std::string text_of(const ClusterScaling& scaling);
/// One for each point.
std::vector<Fields> fields_of(const ClusterScaling& scaling);
/// Where each figure of each series no longer grows, its limit there, and what would help.
std::vector<Fields> ends_of(const ClusterScaling& scaling);
/// Frames/s and thresholds/s, strong and weak.
std::vector<Plot> plots_of(const ClusterScaling& scaling);

}  // namespace pxpl5::host::report
