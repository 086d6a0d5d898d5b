// One frame of a recorded run on many modelled machines, as text, fields, a table and a plot.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/base/reply.hpp"
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

/// Lines end with a newline.
std::string to_text(const ModelledSweep& sweep);
Fields to_fields(const ModelledSweep& sweep);
/// A heading, then a line for each machine.
std::string to_csv(const ModelledSweep& sweep);

/// Throws RequestError (usage) naming the value of a plot's first key that is no number.
void check_axis(const timing::SweptKey& key);

/// Plots frames/s and the time to build over the first key's values, with one line per value of the
/// second key. Throws like check_axis().
Chart plot_of(const ModelledSweep& sweep);

}  // namespace pxpl5::host::inspect
