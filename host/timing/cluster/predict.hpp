// The rate and the delays of a machine on several computers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/timing/cluster/demand.hpp"
#include "host/timing/picture.hpp"

namespace pxpl5::host::timing {

/// Limits of a machine on several computers.
enum class ClusterUnit : std::uint8_t {
    host,
    gp,
    renderer,
    frame_buffer,
    messages,    ///< A node that spends most of its time with the number of its messages.
    io_thread,   ///< Bytes that a node encrypts, sends or receives over the network.
    cores,       ///< All nodes of a computer together.
    link,        ///< One direction of the link of a computer.
    round_trip,  ///< Messages on their way.
    in_flight    ///< Limit of a rate: no unit is busy all the time.
};
inline constexpr std::size_t cluster_units = 10;

/// "GP", "link", ...
std::string_view name_of(ClusterUnit unit);

/// The time that one thread, computer or link needs for a frame.
struct ClusterUse {
    ClusterUnit unit{};
    std::size_t computer = 0;
    double us = 0;
};

struct ClusterTime {
    double frames_per_s = 0;
    double latency_us = 0;              ///< One frame at a time.
    ClusterUse limit;                   ///< The limit of the rate.
    std::vector<ClusterUse> busiest;    ///< Per kind of unit, its busiest; without the last two.
    double network_bytes = 0;           ///< Messages of a picture between computers.
    std::optional<double> isovalue_us;  ///< From a new isovalue to its picture.
    ClusterUnit isovalue_limit{};       ///< The unit that takes most of this time.
    double load_network_bytes = 0;      ///< Slices of the volume between computers.
    double load_us = 0;                 ///< For the slices on the network.

    double frame_ms() const { return 1e3 / frames_per_s; }
    double thresholds_per_s() const { return 1e6 / *isovalue_us; }
};

/// The counts of a picture and of what it shows. Pointers may be null.
struct ClusterWork {
    Picture picture;
    const BuildWork* build = nullptr;    ///< The surface whose isovalue changes.
    const VolumeWork* volume = nullptr;  ///< Loads; also the slabs for `copies`.
    std::uint32_t copies = 1;            ///< See Repeated.
};

/// The rate is that of the busiest unit, or of the frames in flight over the time that one frame
/// takes. README.md has the rules.
ClusterTime cluster_time(const Cluster& cluster, const ClusterPlan& plan, const ClusterWork& work);

/// Bytes of messages of one kind from computer to computer.
struct Crossing {
    std::string_view name;  ///< "bins"
    std::size_t from = 0, to = 0;
    double messages = 0, bytes = 0;
};
/// The messages of a picture and a load between computers, by kind and computers.
std::vector<Crossing> crossings(const Cluster& cluster, const ClusterPlan& plan,
                                const ClusterWork& work);

/// A change of one parameter, and the rate with it.
struct Lever {
    std::string change;  ///< "link.mbit 20000"
    double gain = 0;     ///< 0.9: 90 % more.
};
/// The change that helps most, of each parameter alone: twice the rate of links, half the round
/// trip, no encryption, compression, cores twice as fast, twice as many, half the cost of a
/// message, twice the frames in flight. `of_isovalue`: of thresholds per second, otherwise of
/// frames.
Lever best_lever(const Cluster& cluster, const ClusterPlan& plan, const ClusterWork& work,
                 bool of_isovalue);

}  // namespace pxpl5::host::timing
