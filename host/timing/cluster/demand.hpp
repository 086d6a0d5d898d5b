// The work and the messages of a frame, a build and a load on several computers.
//
//   counts of a run + plan --> Demand: phase by phase, the work of each node, then what it sends
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "host/machine/topology.hpp"
#include "host/timing/cluster/parameters.hpp"
#include "host/timing/counts/work.hpp"

namespace pxpl5::host::timing {

/// The nodes of a machine, numbered host, GPs, Renderers, frame buffer, and their computers.
struct ClusterPlan {
    std::size_t gps = 1, renderers = 1, computers = 1;
    std::vector<std::size_t> computer;  ///< By node.

    std::size_t host() const { return 0; }
    std::size_t gp(std::size_t index) const { return 1 + index; }
    std::size_t renderer(std::size_t index) const { return 1 + gps + index; }
    std::size_t frame_buffer() const { return 1 + gps + renderers; }
    std::size_t nodes() const { return frame_buffer() + 1; }
    bool crosses(std::size_t from, std::size_t to) const { return computer[from] != computer[to]; }
};

/// Places the nodes of `topology` as a machine that runs does, on computers n1, n2, ... with
/// cluster.cores slots each. Host and frame buffer are on n1, or on a computer of their own.
/// Throws RequestError (usage) as place_nodes() does.
ClusterPlan cluster_plan(const Topology& topology, const Cluster& cluster, std::size_t computers);

/// A message body from node to node.
struct Sent {
    std::uint32_t from = 0, to = 0;
    double bytes = 0;
};

/// All nodes work, then send. Each phase begins when the one before has ended.
struct Phase {
    double packed = 1;            ///< Size of a compressed body, of 1; 1: none is compressed.
    bool is_waited_for = true;    ///< False: the next phase begins at the same time.
    std::string_view name;        ///< The kind of messages: "bins", "pixels", ...
    std::vector<double> work_us;  ///< By node; without the cost of messages.
    std::vector<Sent> sent;
};
using Demand = std::vector<Phase>;

/// A volume of `copies` times as many slabs: each slab of the counted one, over and over.
struct Repeated {
    std::uint32_t copies = 1, slabs = 0;
};

/// One frame: begin, bins, pixels, picture. The Renderers of regions are those of the recording if
/// the machine has as many, otherwise they are assigned by the regions' cycles, most first.
Demand frame_demand(const Cluster& cluster, const ClusterPlan& plan, const FrameWork& frame,
                    Repeated repeated = {});

/// A new isovalue: extraction. The request travels with that of the frame, and the counts go to the
/// host while the frame is drawn, so that neither takes time of its own.
Demand build_demand(const Cluster& cluster, const ClusterPlan& plan, const BuildWork& build,
                    Repeated repeated = {});

/// The slices of a volume, from the host to each GP that needs them. GPs have no work.
Demand load_demand(const ClusterPlan& plan, const VolumeWork& volume);

}  // namespace pxpl5::host::timing
