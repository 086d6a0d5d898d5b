// The model: a discrete-event replay of a run's counts on a machine. Integer nanoseconds, one
// thread, no clock: the same machine and run give the same result to the last digit.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/timing/counts/machine.hpp"
#include "host/timing/counts/times.hpp"
#include "host/timing/counts/work.hpp"

namespace pxpl5::host::timing {

/// Replays all steps, one behind the other; frames that follow each other overlap, as many as
/// Machine::frames_in_flight.
/// Throws RequestError (bad_data) if a step needs what the run has not (a build without a volume,
/// a recorded assignment for another number of Renderers).
RunTime simulate(const Machine& machine, const RunWork& run);

/// The rate at which a machine shows one picture over and over, once it has settled.
struct Rate {
    /// 12 pictures by the time from the last pixel of one to that of the twelfth behind it. Frames
    /// are shown at retraces, so that intervals between them vary; those between last pixels do so
    /// only if a frame waits for an earlier one's retrace, in patterns of a few frames. Within 0.5
    /// % of the mean over 240 frames, for machines and loads around the paper's.
    double frames_per_s = 0;
    Ns latency = 0;            ///< Last picture: from the command to the host's knowledge.
    Ns drawn = 0;              ///< Last picture: from the command to its last pixel.
    std::vector<UnitUse> use;  ///< In that time.
    Unit limit{};              ///< limit_of() these.
};
/// Returns the rate of a frame as if it were a picture; see picture_rate(). Throws like simulate().
Rate frame_rate(const Machine& machine, const FrameWork& frame);

}  // namespace pxpl5::host::timing
