#include "host/timing/cluster/demand.hpp"

#include <algorithm>
#include <numeric>

#include "generated/vocabulary.hpp"
#include "host/machine/computers/placement.hpp"
#include "host/timing/replay/frame_plan.hpp"
#include "ringbus/rules/regions.hpp"
#include "ringbus/rules/slabs.hpp"

namespace pxpl5::host::timing {

namespace {

// Bytes of message bodies beside their words, voxels and pixels; see ringbus/PROTOCOL.md. A test
// compares the sums with recorded messages.
constexpr double message_bytes = 80, control_bytes = 500;
constexpr double segment_bytes = 16, region_bytes = 48, tile_bytes = 24;
constexpr double pixel_bytes = sizeof(std::uint32_t), word_bytes = sizeof(std::uint32_t);

std::uint32_t node(std::size_t index) {
    return static_cast<std::uint32_t>(index);
}

Phase phase_of(const ClusterPlan& plan, std::string_view name) {
    return {1, true, name, std::vector<double>(plan.nodes()), {}};
}

/// Graham 1969, as assign_regions() of the GPs: most cycles first, to the least load.
std::vector<std::uint16_t> assigned(const ClusterPlan& plan, const FrameWork& frame) {
    const auto& recorded = frame.assignment;
    if (recorded.size() == frame.regions() && !recorded.empty() &&
        std::ranges::max(recorded) + std::size_t{1} == plan.renderers) {
        return recorded;
    }
    const std::vector<std::uint64_t> cycles = frame.region_cycles();
    std::vector<std::uint16_t> assignment(frame.regions());
    std::vector<std::pair<std::uint64_t, std::size_t>> load(plan.renderers);  // Cycles, regions.
    for (const std::uint32_t region : order_of(Assignment::longest_first, cycles.size(), cycles)) {
        const auto least = std::ranges::min_element(load);
        assignment[region] = static_cast<std::uint16_t>(least - load.begin());
        least->first += cycles[region];
        ++least->second;
    }
    return assignment;
}

/// Bins of a frame, put together from the segments of its regions.
class Bins {
  public:
    Bins(const ClusterPlan& plan, std::span<const std::uint16_t> assignment)
        : plan_(plan),
          assignment_(assignment),
          words_by_gp_(plan.gps),
          words_by_region_(assignment.size()),
          bytes_(plan.gps * plan.renderers, message_bytes),
          newest_(plan.gps * assignment.size(), false) {}

    void add(std::size_t gp, const PartWork& part) {
        const auto words = static_cast<double>(part.words);
        words_by_gp_[gp] += words;
        words_by_region_[part.region] += words;
        double& bytes = bytes_[gp * plan_.renderers + assignment_[part.region]];
        bytes += words * word_bytes + segment_bytes;
        if (auto has = newest_[gp * assignment_.size() + part.region]; !has) {
            has = true;
            bytes += region_bytes;
        }
    }
    double words_of_gp(std::size_t gp) const { return words_by_gp_[gp]; }
    double words_of_region(std::size_t region) const { return words_by_region_[region]; }
    double bytes(std::size_t gp, std::size_t renderer) const {
        return bytes_[gp * plan_.renderers + renderer];
    }

  private:
    const ClusterPlan& plan_;
    std::span<const std::uint16_t> assignment_;
    std::vector<double> words_by_gp_, words_by_region_, bytes_;
    std::vector<bool> newest_;  ///< By GP and region: whether the bin has a segment.
};

/// BeginFrame to the nodes first .. end - 1.
Phase begin_phase(const ClusterPlan& plan, std::size_t first, std::size_t end) {
    Phase phase = phase_of(plan, "begin");
    for (std::size_t to = first; to < end; ++to) {
        phase.sent.push_back({node(plan.gp(0)), node(to), control_bytes});
    }
    return phase;
}

Phase gp_phase(const Cluster& cluster, const ClusterPlan& plan, const Bins& bins) {
    Phase phase = phase_of(plan, "bins");
    phase.packed = cluster.compress != 0 ? cluster.compress_bins : 1;
    for (std::size_t gp = 0; gp < plan.gps; ++gp) {
        phase.work_us[plan.gp(gp)] = bins.words_of_gp(gp) * cluster.gp_word_ns * us_per_ns;
        for (std::size_t r = 0; r < plan.renderers; ++r) {
            phase.sent.push_back({node(plan.gp(gp)), node(plan.renderer(r)), bins.bytes(gp, r)});
        }
    }
    return phase;
}

Phase renderer_phase(const Cluster& cluster, const ClusterPlan& plan, const Bins& bins,
                     std::span<const std::uint16_t> assignment, bool reads_out) {
    Phase phase = phase_of(plan, "pixels");
    phase.packed = cluster.compress != 0 ? cluster.compress_pixels : 1;
    std::vector<double> bytes(plan.renderers, message_bytes);
    for (std::size_t region = 0; region < assignment.size(); ++region) {
        const double words = bins.words_of_region(region);
        phase.work_us[plan.renderer(assignment[region])] +=
            words * cluster.renderer_word_ns * us_per_ns + cluster.renderer_region_us +
            (words > 0 ? cluster.renderer_shaded_us : 0);
        bytes[assignment[region]] +=
            tile_bytes + (reads_out ? pixel_bytes * region_px * region_px : 0);
    }
    for (std::size_t r = 0; r < plan.renderers; ++r) {
        phase.sent.push_back({node(plan.renderer(r)), node(plan.frame_buffer()), bytes[r]});
    }
    return phase;
}

Phase picture_phase(const Cluster& cluster, const ClusterPlan& plan, const FrameWork& frame) {
    Phase phase = phase_of(plan, "picture");
    phase.packed = cluster.compress != 0 ? cluster.compress_pixels : 1;
    const auto regions = static_cast<double>(frame.regions());
    phase.work_us[plan.frame_buffer()] = regions * cluster.frame_buffer_region_us;
    const double pixels = static_cast<double>(frame.width) * frame.height * frame.views;
    phase.sent.push_back({node(plan.frame_buffer()), node(plan.host()),
                          message_bytes + (frame.reads_out ? pixels * pixel_bytes : 0)});
    return phase;
}

/// Calls take(slab, GP) for every copy of `slab`.
template <typename Take>
void for_copies(const ClusterPlan& plan, std::uint32_t slab, Repeated repeated, const Take& take) {
    for (std::uint32_t copy = 0; copy < repeated.copies; ++copy) {
        take((std::size_t{copy} * repeated.slabs + slab) % plan.gps);
    }
}

}  // namespace

ClusterPlan cluster_plan(const Topology& topology, const Cluster& cluster, std::size_t computers) {
    std::vector<ComputerSlots> slots;
    for (std::size_t i = 0; i < computers; ++i) {
        slots.push_back({"n" + std::to_string(i + 1), static_cast<int>(cluster.cores)});
    }
    Topology one = topology;
    one.frame_buffer.count = 1;
    ClusterPlan plan{static_cast<std::size_t>(topology.gp.count),
                     static_cast<std::size_t>(topology.renderer.count),
                     computers + (cluster.host_apart ? 1 : 0),
                     {}};
    for (const int place : place_nodes(roster_of(one), one, slots)) {
        const std::size_t own = cluster.host_apart ? computers : 0;
        plan.computer.push_back(place == own_computer ? own : static_cast<std::size_t>(place) - 1);
    }
    return plan;
}

Demand frame_demand(const Cluster& cluster, const ClusterPlan& plan, const FrameWork& frame,
                    Repeated repeated) {
    const std::vector<std::uint16_t> assignment = assigned(plan, frame);
    Bins bins(plan, assignment);
    for (const PartWork& part : frame.parts) {
        if (part.kind == PartKind::segment) {
            for_copies(plan, part.slab, repeated, [&](std::size_t gp) { bins.add(gp, part); });
        }
    }
    Demand demand;
    Phase& request = demand.emplace_back(phase_of(plan, "request"));
    request.work_us[plan.host()] = static_cast<double>(assignment.size()) * cluster.host_region_us;
    request.sent.push_back({node(plan.host()), node(plan.gp(0)), control_bytes});
    demand.push_back(begin_phase(plan, plan.gp(1), plan.renderer(0)));
    demand.push_back(begin_phase(plan, plan.renderer(0), plan.nodes()));
    demand.back().is_waited_for = false;  // They have it before the first bin.
    demand.push_back(gp_phase(cluster, plan, bins));
    demand.push_back(renderer_phase(cluster, plan, bins, assignment, frame.reads_out));
    demand.push_back(picture_phase(cluster, plan, frame));
    return demand;
}

Demand build_demand(const Cluster& cluster, const ClusterPlan& plan, const BuildWork& build,
                    Repeated repeated) {
    Demand demand = {phase_of(plan, "extraction")};
    for (const SlabWork& slab : build.slabs) {
        for_copies(plan, slab.slab, repeated, [&](std::size_t gp) {
            demand.front().work_us[plan.gp(gp)] +=
                cluster.gp_slab_us +
                static_cast<double>(slab.triangles) * cluster.gp_triangle_ns * us_per_ns;
        });
    }
    return demand;
}

Demand load_demand(const ClusterPlan& plan, const VolumeWork& volume) {
    Demand demand = {phase_of(plan, "slices")};
    const SlabSets sets{.nz = static_cast<int>(volume.nz), .gp_count = static_cast<int>(plan.gps)};
    const double slice_bytes = static_cast<double>(volume.nx) * volume.ny * volume.voxel_bytes;
    for (std::size_t gp = 0; gp < plan.gps; ++gp) {
        const std::size_t slices = sets.slices_needed(static_cast<int>(gp)).size();
        if (slices > 0) {
            demand.front().sent.push_back(
                {node(plan.host()), node(plan.gp(gp)), static_cast<double>(slices) * slice_bytes});
        }
    }
    return demand;
}

}  // namespace pxpl5::host::timing
