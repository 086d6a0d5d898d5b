#include "host/report/cluster_scaling.hpp"

#include <algorithm>

#include "host/machine/modelled_topology.hpp"
#include "host/report/scaling.hpp"

namespace pxpl5::host::report {

namespace {

constexpr std::uint32_t most_computers = 256;
constexpr double bytes_per_mb = 1e6, least_efficiency = 0.5;

struct ClusterCase {
    timing::ClusterPlan plan;
    timing::ClusterWork work;
};

ClusterCase case_of(Topology topology, const timing::Cluster& cluster, std::uint32_t computers,
                    bool is_weak, const timing::PaperCase& work) {
    topology.gp.count = topology.renderer.count =
        static_cast<int>(nodes_on(computers, nodes_per_computer(cluster)));
    return {timing::cluster_plan(topology, cluster, computers),
            {{0, {&work.frame}}, &work.build, &work.volume, is_weak ? computers : 1}};
}

ClusterSeries series_of(const Topology& topology, const timing::Cluster& cluster, bool is_weak,
                        const timing::PaperCase& work) {
    ClusterSeries series;
    for (std::uint32_t computers = 1; computers <= most_computers; computers *= 2) {
        const ClusterCase one = case_of(topology, cluster, computers, is_weak, work);
        const timing::ClusterTime time = timing::cluster_time(cluster, one.plan, one.work);
        series.points.push_back({computers,
                                 {time.frames_per_s, time.limit.unit},
                                 {time.thresholds_per_s(), time.isovalue_limit},
                                 time.network_bytes / bytes_per_mb});
    }
    const auto lever = [&](ClusterRate ClusterPoint::*rate, bool of_isovalue) {
        const std::size_t last = series.points.size() - 1;
        const std::size_t at = end_of_growth(series.relative(rate), is_weak).value_or(last);
        const std::uint32_t computers = series.points[std::min(at + 1, last)].computers;
        const ClusterCase one = case_of(topology, cluster, computers, is_weak, work);
        return timing::best_lever(cluster, one.plan, one.work, of_isovalue);
    };
    series.frames_lever = lever(&ClusterPoint::frames, false);
    series.thresholds_lever = lever(&ClusterPoint::thresholds, true);
    return series;
}

}  // namespace

std::vector<double> ClusterSeries::relative(ClusterRate ClusterPoint::*rate) const {
    std::vector<double> factors;
    for (const ClusterPoint& point : points) {
        factors.push_back((point.*rate).per_s / (points.front().*rate).per_s);
    }
    return factors;
}

std::uint32_t nodes_per_computer(const timing::Cluster& cluster) {
    return std::max(1U, static_cast<std::uint32_t>(cluster.cores / 2));
}

std::uint32_t nodes_on(std::uint32_t computers, std::uint32_t per_computer) {
    return std::min<std::uint32_t>(computers * per_computer, max_modelled_nodes);
}

std::optional<std::size_t> end_of_growth(const std::vector<double>& relative, bool is_weak) {
    if (!is_weak) {
        return saturation(relative);
    }
    const auto found = std::ranges::find_if(
        relative, [](double efficiency) { return efficiency < least_efficiency; });
    if (found == relative.end()) {  // The first is 1.
        return std::nullopt;
    }
    return static_cast<std::size_t>(found - relative.begin()) - 1;
}

ClusterScalingRow cluster_scaling_of(const Topology& topology, const timing::Cluster& cluster,
                                     const std::string& name, const timing::PaperCase& work) {
    return {name, series_of(topology, cluster, false, work),
            series_of(topology, cluster, true, work)};
}

}  // namespace pxpl5::host::report
