// Modelled times, and how busy the units of the machine are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace pxpl5::host::timing {

using Ns = std::int64_t;  ///< Modelled time.

/// Units that can be the limit. `host` is its software; `waiting`, which has no UnitUse, is what
/// limits where nothing is busy enough: for a retrace, or one unit for another.
enum class Unit : std::uint8_t { host, host_link, gp, ring, renderer, frame_buffer, waiting };
std::string_view name_of(Unit unit);

/// How busy the nodes, or channels, of a kind were.
struct UnitUse {
    Unit unit{};
    double mean = 0;          ///< Share of the time, 0..1, over all of the kind.
    double busiest = 0;       ///< Share of the busiest node.
    std::uint32_t index = 0;  ///< Index of that node; for frame buffers, index of the port.
};

/// Share of the time that a unit's busiest node works if the unit is the limit, 0..1.
inline constexpr double least_limit_share = 0.9;

/// The kind with the busiest node. `use` is not empty.
const UnitUse& busiest_of(const std::vector<UnitUse>& use);
/// Its unit, or `waiting` if it is busy for less than `least_limit_share`.
Unit limit_of(const std::vector<UnitUse>& use);

/// One step of the run.
struct StepTime {
    std::size_t step = 0;      ///< Index in RunWork::steps.
    Ns begin = 0;              ///< The host's command.
    Ns end = 0;                ///< The host knows that it is done; of a frame: it is shown.
    std::vector<UnitUse> use;  ///< Between the two, one for each Unit.
    Unit limit{};              ///< limit_of() these.
};

/// Packets and their words, headers included.
struct RingCount {
    std::uint16_t source = 0, destination = 0, channel = 0;  ///< Places on the ring, from 0.
    std::uint64_t messages = 0, words = 0;                   ///< A message of the ring is a packet.
};

struct RunTime {
    std::vector<StepTime> steps;
    std::vector<RingCount> ring;  ///< Ascending, those that are not 0.
    std::uint64_t events = 0;
};

}  // namespace pxpl5::host::timing
