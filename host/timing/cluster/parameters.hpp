// The parameters of the model of several computers of today.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace pxpl5::host::timing {

/// Names, units, ranges and sources are in cluster_rows().
struct Cluster {
#define PXPL5_CLUSTER(field, name, unit, least, most, usual, source) double field = usual;
#include "host/timing/cluster/parameters.def"
    bool host_apart = false;  ///< The host has a computer of its own, beside the nodes' computers.
};

struct ClusterRow {
    std::string_view name;  ///< "link.mbit"
    std::string_view unit;
    double Cluster::*value;
    double least = 0, most = 0, usual = 0;
    std::string_view source;
};

/// All numbers, in the order of the table.
std::span<const ClusterRow> cluster_rows();

inline constexpr double us_per_ns = 1e-3;  ///< Parameters are in both.

/// Sets rate, payload and round trip. Throws RequestError (usage) that names the presets.
void apply_link(Cluster& cluster, std::string_view preset);

/// Sets the parameter `name`. Throws RequestError (usage) if it does not exist or if the value is
/// out of its range.
void set_cluster(Cluster& cluster, std::string_view name, double value);

/// The command line of the model.
struct ClusterOptions {
    std::optional<std::string> link{};  ///< A preset.
    std::optional<double> link_mbit{}, cores{};
    std::vector<std::string> settings{};  ///< "curve=0", each of the table.
    bool host_apart = false;

    bool is_empty() const;
};

/// The parameters, changed in the order of the members. Throws as apply_link() and set_cluster(),
/// and for settings that are no NAME=NUMBER.
Cluster cluster_of(const ClusterOptions& options);

}  // namespace pxpl5::host::timing
