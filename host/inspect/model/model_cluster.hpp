// A recorded run on several computers of today.
#pragma once

#include <string>
#include <vector>

#include "host/base/answer.hpp"
#include "host/machine/topology.hpp"
#include "host/timing/cluster/predict.hpp"

namespace pxpl5::host::inspect {

/// The run's last picture on one number of computers.
struct ModelledComputers {
    std::size_t computers = 0;
    timing::ClusterPlan plan;
    timing::ClusterTime time;
    timing::Lever lever;  ///< The change that helps frames/s most.
};

struct ModelledCluster {
    Topology topology;  ///< Its nodes and their placement.
    timing::Cluster cluster;
    std::uint32_t frame = 0, samples = 1;  ///< The picture's first pass; how many it has.
    std::vector<std::string> missing;
    std::vector<ModelledComputers> points;
    std::vector<timing::Crossing> crossings;  ///< Messages of the last point.
};

/// computers  "3", "1,2,4", "1..256*2".
/// Throws RequestError: usage if a number is not from 1 to 256; bad_data if the run has no picture.
ModelledCluster modelled_cluster(const Topology& topology, const timing::Cluster& cluster,
                                 const std::string& computers, const timing::RunWork& work);

/// The parameters, with units, ranges and sources, then a row per number of computers, and what
/// crosses the network with the last one. CSV has a row per number of computers.
Answer answer_of(const ModelledCluster& model);

}  // namespace pxpl5::host::inspect
