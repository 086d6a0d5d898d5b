#include "host/timing/cluster/parameters.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "host/base/error.hpp"

namespace pxpl5::host::timing {

namespace {

constexpr std::array rows = {
#define PXPL5_CLUSTER(field, name, unit, least, most, usual, source) \
    ClusterRow{name, unit, &Cluster::field, least, most, usual, source},
#include "host/timing/cluster/parameters.def"
};

/// A kind of network. Rates are those of the standards; round trips are ours.
struct LinkPreset {
    std::string_view name;
    double mbit = 0, payload = 0, round_trip_us = 0;
};
constexpr std::array presets = {
    LinkPreset{"1g", 1'000, 0.94, 100},
    LinkPreset{"10g", 10'000, 0.94, 60},
    LinkPreset{"25g", 25'000, 0.94, 40},
    LinkPreset{"100g", 100'000, 0.94, 30},
    // 4x HDR, as IP over InfiniBand with packets of 2,044 bytes.
    LinkPreset{"infiniband", 200'000, 0.95, 20},
};

template <typename List>
std::string names_of(const List& list) {
    std::vector<std::string_view> names;
    for (const auto& each : list) {
        names.push_back(each.name);
    }
    return fmt::format("{}", fmt::join(names, ", "));
}

double number_of(std::string_view setting, std::string_view text) {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) {
        throw RequestError(ExitCode::usage,
                           fmt::format("--cluster-set {}: must be NAME=NUMBER", setting));
    }
    return value;
}

}  // namespace

std::span<const ClusterRow> cluster_rows() {
    return rows;
}

void apply_link(Cluster& cluster, std::string_view preset) {
    const auto found = std::ranges::find(presets, preset, &LinkPreset::name);
    if (found == presets.end()) {
        throw RequestError(ExitCode::usage,
                           fmt::format("--link {}: must be one of {}", preset, names_of(presets)));
    }
    cluster.link_mbit = found->mbit;
    cluster.link_payload = found->payload;
    cluster.round_trip_us = found->round_trip_us;
}

void set_cluster(Cluster& cluster, std::string_view name, double value) {
    const auto row = std::ranges::find(rows, name, &ClusterRow::name);
    if (row == rows.end()) {
        throw RequestError(ExitCode::usage, fmt::format("--cluster-set {}: must be one of {}", name,
                                                        names_of(rows)));
    }
    // Written so that what is no number is out of range, too.
    if (!(value >= row->least && value <= row->most)) {
        throw RequestError(ExitCode::usage, fmt::format("{} is {} {}, must be {} to {}", name,
                                                        value, row->unit, row->least, row->most));
    }
    cluster.*(row->value) = value;
}

bool ClusterOptions::is_empty() const {
    return !link && !link_mbit && !cores && settings.empty() && !host_apart;
}

Cluster cluster_of(const ClusterOptions& options) {
    Cluster cluster;
    cluster.host_apart = options.host_apart;
    if (options.link) {
        apply_link(cluster, *options.link);
    }
    if (options.link_mbit) {
        set_cluster(cluster, "link.mbit", *options.link_mbit);
    }
    if (options.cores) {
        set_cluster(cluster, "cores", *options.cores);
    }
    for (const std::string& text : options.settings) {
        const std::size_t equals = std::min(text.find('='), text.size());
        const std::string_view value = std::string_view(text).substr(equals);
        set_cluster(cluster, std::string_view(text).substr(0, equals),
                    number_of(text, value.substr(value.empty() ? 0 : 1)));
    }
    return cluster;
}

}  // namespace pxpl5::host::timing
