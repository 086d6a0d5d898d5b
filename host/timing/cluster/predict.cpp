#include "host/timing/cluster/predict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <tuple>

namespace pxpl5::host::timing {

namespace {

constexpr std::array<std::string_view, cluster_units> unit_names = {
    "host",       "GP",    "Renderer", "frame buffer", "messages",
    "I/O thread", "cores", "link",     "round trip",   "frames in flight"};
constexpr double us_per_s = 1e6, bits_per_byte = 8;

ClusterUnit role_of(const ClusterPlan& plan, std::size_t node) {
    return node == plan.host()          ? ClusterUnit::host
           : node < plan.renderer(0)    ? ClusterUnit::gp
           : node < plan.frame_buffer() ? ClusterUnit::renderer
                                        : ClusterUnit::frame_buffer;
}

/// Costs of messages, in us.
struct MessageCosts {
    explicit MessageCosts(const Cluster& c)
        : end(c.message_us / c.core_speed),
          io(c.curve * c.curve_message_us / c.core_speed),
          io_byte((c.tcp_byte_ns + c.curve * c.curve_byte_ns) * us_per_ns / c.core_speed),
          pack_byte(c.compress_byte_ns * us_per_ns / c.core_speed),
          link_byte(bits_per_byte / (c.link_mbit * c.link_payload)) {}

    double io_us(double bytes) const { return io + bytes * io_byte; }
    double link_us(double bytes) const { return bytes * link_byte; }

    double end;          ///< At each end.
    double io, io_byte;  ///< At each end, on the network.
    double pack_byte;    ///< At each end, by the node itself.
    double link_byte;
};

/// The times of some phases, in us.
struct Sums {
    explicit Sums(const ClusterPlan& plan)
        : work(plan.nodes()),
          messages(plan.nodes()),
          receiving(plan.nodes()),
          io(plan.nodes()),
          link_out(plan.computers),
          link_in(plan.computers) {}

    std::vector<double> work, messages, receiving, io;  ///< By node. The third is in the others.
    std::vector<double> link_out, link_in;              ///< By computer.
    double largest = 0;  ///< Bytes of the largest message on the network.
    bool has_network = false;
    double bytes = 0;

    void add(const MessageCosts& costs, double speed, const ClusterPlan& plan, const Phase& phase) {
        for (std::size_t n = 0; n < work.size(); ++n) {
            work[n] += phase.work_us[n] / speed;
        }
        for (const Sent& one : phase.sent) {
            messages[one.from] += costs.end;
            messages[one.to] += costs.end;
            receiving[one.to] += costs.end;
            if (plan.crosses(one.from, one.to)) {
                add_crossing(costs, plan, one, phase.packed);
            }
        }
    }
    void add_crossing(const MessageCosts& costs, const ClusterPlan& plan, const Sent& one,
                      double packed) {
        const double sent_bytes = one.bytes * packed;
        const double pack_us = packed < 1 ? one.bytes * costs.pack_byte : 0;
        has_network = true;
        bytes += sent_bytes;
        largest = std::max(largest, sent_bytes);
        for (const std::uint32_t end : {one.from, one.to}) {
            work[end] += pack_us;
            io[end] += costs.io_us(sent_bytes);
        }
        receiving[one.to] += pack_us;
        link_out[plan.computer[one.from]] += costs.link_us(sent_bytes);
        link_in[plan.computer[one.to]] += costs.link_us(sent_bytes);
    }
    double own(std::size_t node) const { return work[node] + messages[node]; }
};

/// The role of a node, unless messages take most of its time.
ClusterUnit unit_of(const ClusterPlan& plan, const Sums& sums, std::size_t node) {
    return sums.messages[node] > sums.work[node] ? ClusterUnit::messages : role_of(plan, node);
}

ClusterUse greatest(ClusterUnit unit, const std::vector<double>& by_computer) {
    const auto most = std::ranges::max_element(by_computer);
    return {unit, static_cast<std::size_t>(most - by_computer.begin()), *most};
}

/// The busiest unit of each kind.
std::vector<ClusterUse> busiest_of(const Cluster& cluster, const ClusterPlan& plan,
                                   const Sums& sums) {
    std::vector<ClusterUse> list;
    for (const ClusterUnit unit :
         {ClusterUnit::host, ClusterUnit::gp, ClusterUnit::renderer, ClusterUnit::frame_buffer,
          ClusterUnit::messages, ClusterUnit::io_thread}) {
        list.push_back({unit, 0, 0});
    }
    std::vector<double> cores(plan.computers), links(plan.computers);
    for (std::size_t n = 0; n < plan.nodes(); ++n) {
        const std::size_t at = plan.computer[n];
        const auto take = [&](ClusterUnit unit, double us) {
            ClusterUse& use = list[static_cast<std::size_t>(unit)];
            use = us > use.us ? ClusterUse{unit, at, us} : use;
        };
        take(unit_of(plan, sums, n), sums.own(n));
        take(ClusterUnit::io_thread, sums.io[n]);
        cores[at] += (sums.own(n) + sums.io[n]) / cluster.cores;
    }
    for (std::size_t c = 0; c < plan.computers; ++c) {
        links[c] = std::max(sums.link_in[c], sums.link_out[c]);
    }
    list.push_back(greatest(ClusterUnit::cores, cores));
    list.push_back(greatest(ClusterUnit::link, links));
    return list;
}

using Shares = std::array<double, cluster_units>;

/// Adds the time of the slowest node, or of all nodes that share the cores of a computer.
void add_slowest(const Cluster& cluster, const ClusterPlan& plan, const Sums& sums,
                 bool of_receiving, Shares& shares) {
    std::vector<double> cores(plan.computers);
    ClusterUse slowest;
    for (std::size_t n = 0; n < plan.nodes(); ++n) {
        const double us = of_receiving ? sums.receiving[n] : sums.own(n) - sums.receiving[n];
        cores[plan.computer[n]] += us / cluster.cores;
        if (us > slowest.us) {
            slowest = {unit_of(plan, sums, n), plan.computer[n], us};
        }
    }
    const ClusterUse all = greatest(ClusterUnit::cores, cores);
    slowest = all.us > slowest.us ? all : slowest;
    shares[static_cast<std::size_t>(slowest.unit)] += slowest.us;
}

/// Adds the times of one phase that nothing else overlaps.
void add_phase(const Cluster& cluster, const ClusterPlan& plan, const Phase& phase,
               Shares& shares) {
    const MessageCosts costs(cluster);
    Sums sums(plan);
    sums.add(costs, cluster.core_speed, plan, phase);
    const std::vector<ClusterUse> busiest = busiest_of(cluster, plan, sums);
    const auto us_of = [&](ClusterUnit unit) {
        return std::ranges::find(busiest, unit, &ClusterUse::unit)->us;
    };
    add_slowest(cluster, plan, sums, false, shares);
    add_slowest(cluster, plan, sums, true, shares);
    if (!sums.has_network) {
        return;
    }
    // The network: the largest message passes both ends and the link, the rest keeps the pace of
    // the slowest of them.
    const double io_us = us_of(ClusterUnit::io_thread), link_us = us_of(ClusterUnit::link);
    const double first_io = costs.io_us(sums.largest), first_link = costs.link_us(sums.largest);
    const double rest_io = io_us - first_io, rest_link = link_us - first_link;
    shares[static_cast<std::size_t>(ClusterUnit::io_thread)] +=
        2 * first_io + (rest_io > rest_link ? rest_io : 0);
    shares[static_cast<std::size_t>(ClusterUnit::link)] +=
        first_link + (rest_io > rest_link ? 0 : rest_link);
    shares[static_cast<std::size_t>(ClusterUnit::round_trip)] += cluster.round_trip_us / 2;
}

double sum_of(const Shares& shares) {
    double sum = 0;
    for (const double one : shares) {
        sum += one;
    }
    return sum;
}

Shares shares_of(const Cluster& cluster, const ClusterPlan& plan, const Demand& demand) {
    Shares shares{};
    for (const Phase& phase : demand) {
        if (phase.is_waited_for) {
            add_phase(cluster, plan, phase, shares);
        }
    }
    return shares;
}

Repeated repeated_of(const ClusterWork& work) {
    return {work.copies, work.volume != nullptr ? work.volume->nz - 1 : 0};
}

void add_isovalue(const Cluster& cluster, const ClusterPlan& plan, const ClusterWork& work,
                  const Shares& frame, double before_last_us, ClusterTime& time) {
    Shares shares =
        shares_of(cluster, plan, build_demand(cluster, plan, *work.build, repeated_of(work)));
    for (std::size_t i = 0; i < cluster_units; ++i) {
        shares[i] += frame[i];
    }
    time.isovalue_us = sum_of(shares) + before_last_us;
    time.isovalue_limit =
        static_cast<ClusterUnit>(std::ranges::max_element(shares) - shares.begin());
}

void add_load(const Cluster& cluster, const ClusterPlan& plan, const VolumeWork& volume,
              ClusterTime& time) {
    Sums sums(plan);
    sums.add(MessageCosts(cluster), cluster.core_speed, plan, load_demand(plan, volume).front());
    time.load_network_bytes = sums.bytes;
    for (const ClusterUse& use : busiest_of(cluster, plan, sums)) {
        if (use.unit == ClusterUnit::link || use.unit == ClusterUnit::io_thread) {
            time.load_us = std::max(time.load_us, use.us);
        }
    }
}

/// The parameters with one change each.
std::vector<std::pair<std::string, Cluster>> changed(const Cluster& cluster) {
    std::vector<std::pair<std::string, Cluster>> list;
    const auto add = [&](std::string_view name, double Cluster::*value, double to) {
        if (cluster.*value != to) {
            list.emplace_back(fmt::format("{} {:g}", name, to), cluster);
            list.back().second.*value = to;
        }
    };
    add("link.mbit", &Cluster::link_mbit, 2 * cluster.link_mbit);
    add("link.round_trip_us", &Cluster::round_trip_us, cluster.round_trip_us / 2);
    add("curve", &Cluster::curve, 0);
    add("compress", &Cluster::compress, 1);
    add("core.speed", &Cluster::core_speed, 2 * cluster.core_speed);
    add("cores", &Cluster::cores, 2 * cluster.cores);
    add("message_us", &Cluster::message_us, cluster.message_us / 2);
    add("frames_in_flight", &Cluster::frames_in_flight, 2 * cluster.frames_in_flight);
    return list;
}

}  // namespace

std::string_view name_of(ClusterUnit unit) {
    return unit_names[static_cast<std::size_t>(unit)];
}

ClusterTime cluster_time(const Cluster& cluster, const ClusterPlan& plan, const ClusterWork& work) {
    Sums all(plan);
    Shares last{};
    for (const FrameWork* pass : work.picture.passes) {
        const Demand demand = frame_demand(cluster, plan, *pass, repeated_of(work));
        for (const Phase& phase : demand) {
            all.add(MessageCosts(cluster), cluster.core_speed, plan, phase);
        }
        last = shares_of(cluster, plan, demand);
    }
    ClusterTime time;
    time.busiest = busiest_of(cluster, plan, all);
    time.network_bytes = all.bytes;
    time.limit = *std::ranges::max_element(time.busiest, {}, &ClusterUse::us);
    // Passes follow each other at the pace of the busiest; the last one then goes its way.
    const auto passes = static_cast<double>(work.picture.passes.size());
    const double before_last_us = time.limit.us * (passes - 1) / passes;
    time.latency_us = sum_of(last) + before_last_us;
    // The frames in flight are all at work at once.
    const double in_flight_us = sum_of(last) * passes / cluster.frames_in_flight;
    if (in_flight_us > time.limit.us) {
        time.limit = {ClusterUnit::in_flight, plan.computer[plan.host()], in_flight_us};
    }
    time.frames_per_s = us_per_s / time.limit.us;
    if (work.build != nullptr) {
        add_isovalue(cluster, plan, work, last, before_last_us, time);
    }
    if (work.volume != nullptr) {
        add_load(cluster, plan, *work.volume, time);
    }
    return time;
}

std::vector<Crossing> crossings(const Cluster& cluster, const ClusterPlan& plan,
                                const ClusterWork& work) {
    std::map<std::tuple<std::string_view, std::size_t, std::size_t>, Crossing> sums;
    std::vector<Phase> phases;
    for (const FrameWork* pass : work.picture.passes) {
        std::ranges::move(frame_demand(cluster, plan, *pass, repeated_of(work)),
                          std::back_inserter(phases));
    }
    if (work.volume != nullptr) {
        std::ranges::move(load_demand(plan, *work.volume), std::back_inserter(phases));
    }
    for (const Phase& phase : phases) {
        for (const Sent& one : phase.sent) {
            const std::size_t from = plan.computer[one.from], to = plan.computer[one.to];
            if (from != to) {
                Crossing& sum = sums[{phase.name, from, to}];
                sum = {phase.name, from, to, sum.messages + 1, sum.bytes + one.bytes};
            }
        }
    }
    std::vector<Crossing> list;
    for (const auto& [key, one] : sums) {
        list.push_back(one);
    }
    return list;
}

Lever best_lever(const Cluster& cluster, const ClusterPlan& plan, const ClusterWork& work,
                 bool of_isovalue) {
    const auto rate = [&](const Cluster& one) {
        const ClusterTime time = cluster_time(one, plan, work);
        return of_isovalue ? time.thresholds_per_s() : time.frames_per_s;
    };
    const double now = rate(cluster);
    Lever best;
    for (const auto& [change, one] : changed(cluster)) {
        if (const double gain = rate(one) / now - 1; gain > best.gain) {
            best = {change, gain};
        }
    }
    return best;
}

}  // namespace pxpl5::host::timing
