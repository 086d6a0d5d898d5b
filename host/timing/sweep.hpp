// Trying machines: parameters run through values, each machine timed on the same work.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/timing/simulate.hpp"

namespace pxpl5::host::timing {

inline constexpr std::size_t max_swept_keys = 2, max_swept_machines = 4096;

/// A key of the topology, as of --set, and its values, one machine each.
struct SweptKey {
    std::string key;
    std::vector<std::string> values;
};

/// "gp.count=1..64" (all whole numbers), "gp.count=1..64*2" (1, 2, 4, ... 64),
/// "ring.channel_mb_s=40,80,160", "share=even,own".
/// Throws RequestError (usage) that names the text and what is wrong with it.
SweptKey parse_sweep(std::string_view text);

/// A machine of a sweep, and the values that make it, in the order of the keys.
struct TriedMachine {
    std::vector<std::string> values;
    Machine machine;
};

/// Every machine that sweep() times, in its order; cheap.
/// Throws RequestError (usage) for keys and values that apply_override() or machine_of() refuses, a
/// key that is there twice, too many keys or machines.
std::vector<TriedMachine> machines_of(const Topology& plan, std::span<const SweptKey> keys);

/// The machine's content at the request of that step's frame: the volume and each surface's newest
/// revision, in the order of their builds. Does not include the frame.
RunWork setting_of(const RunWork& run, std::size_t frame_step);

/// One machine of a sweep.
struct SweptMachine {
    std::vector<std::string> values;  ///< In the order of the keys.
    std::optional<Ns> load, build;    ///< All surfaces together; empty without work.
    Unit build_limit{};               ///< Limit of the slowest surface.
    Rate rate;                        ///< Steady-state rate of the picture.
};

/// Times one picture of a run, and what it shows, on every machine: all values of the last key for
/// each of the one before.
///
/// plan  The machine without the keys' values.
/// keys  1 or 2.
/// Throws RequestError as machines_of(); usage for a step that is no pass of a whole picture; those
/// of simulate().
std::vector<SweptMachine> sweep(const Topology& plan, std::span<const SweptKey> keys,
                                const RunWork& run, std::size_t frame_step);

}  // namespace pxpl5::host::timing
