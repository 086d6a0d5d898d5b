// A recorded run on one modelled machine.
#pragma once

#include <string>
#include <vector>

#include "host/base/answer.hpp"
#include "host/machine/topology.hpp"
#include "host/timing/simulate.hpp"

namespace pxpl5::host::inspect {

struct ModelledRun {
    Topology plan;
    timing::Machine machine;
    timing::RunWork work;
    timing::RunTime time;
    std::vector<timing::Rate> rates;  ///< Steady-state rates, one per entry of pictures_of(work).
};

/// Throws as machine_of(), simulate() and picture_rate() do.
ModelledRun modelled(const Topology& plan, timing::RunWork work);

/// CSV has a row per step.
Answer answer_of(const ModelledRun& run);

}  // namespace pxpl5::host::inspect
