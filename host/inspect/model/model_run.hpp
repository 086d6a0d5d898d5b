// A recorded run on one modelled machine, as text, as fields and as a table for other programs.
#pragma once

#include <string>
#include <vector>

#include "host/base/reply.hpp"
#include "host/machine/topology.hpp"
#include "host/timing/simulate.hpp"

namespace pxpl5::host::inspect {

struct ModelledRun {
    Topology plan;
    timing::Machine machine;
    timing::RunWork work;
    timing::RunTime time;
    std::vector<timing::Rate> rates;  ///< Of pictures_of(work), each shown over and over.
};

/// Throws as machine_of(), simulate() and picture_rate() do.
ModelledRun modelled(const Topology& plan, timing::RunWork work);

/// Lines end with a newline.
std::string to_text(const ModelledRun& run);
Fields to_fields(const ModelledRun& run);
/// A heading, then a line for each step.
std::string to_csv(const ModelledRun& run);

}  // namespace pxpl5::host::inspect
