// One frame of a recorded run on many modelled machines, and its plot.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/base/answer.hpp"
#include "host/chart/chart.hpp"
#include "host/timing/sweep.hpp"

namespace pxpl5::host::inspect {

struct ModelledSweep {
    Topology plan;
    std::vector<timing::SweptKey> keys;
    std::uint32_t frame = 0, samples = 1;  ///< The picture's first pass; how many it has.
    std::vector<std::string> missing;
    std::vector<timing::SweptMachine> machines;
};

/// Sweeps over the run's last picture. Throws RequestError: bad_data if it has none; else as
/// timing::sweep() does.
ModelledSweep swept(const Topology& plan, std::vector<timing::SweptKey> keys,
                    const timing::RunWork& work);

/// CSV has a row per machine.
Answer answer_of(const ModelledSweep& sweep);

/// Throws RequestError (usage) if a value of the plot's first key is not a number.
void check_axis(const timing::SweptKey& key);

/// Plots frames/s and the time to build over the first key's values, with one line per value of the
/// second key. Throws like check_axis().
Chart plot_of(const ModelledSweep& sweep);

}  // namespace pxpl5::host::inspect
