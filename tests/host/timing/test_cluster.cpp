// The model of several computers, with figures that can be computed by hand.
#include <doctest/doctest.h>

#include <numeric>
#include <string>

#include "host/base/error.hpp"
#include "host/timing/cluster/predict.hpp"
#include "tests/host/timing/machines.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::timing;

namespace {

constexpr double near = 1e-9;
constexpr double region_bytes = 4 * 128 * 128;

/// Nothing costs time but what a test sets.
Cluster free_of_cost() {
    Cluster cluster;
    for (const ClusterRow& row : cluster_rows()) {
        if (row.unit.find(" per ") != std::string_view::npos || row.unit == "us") {
            cluster.*row.value = 0;
        }
    }
    cluster.curve = 0;
    cluster.link_payload = 1;
    cluster.link_mbit = 800;  // 100 bytes a microsecond.
    cluster.cores = 4;
    return cluster;
}

/// GPs on n1, Renderers on n2.
Topology apart(int gps, int renderers) {
    Topology topology;
    topology.gp.count = gps;
    topology.renderer.count = renderers;
    topology.frame_buffer.count = 1;
    topology.gp.computer = {"n1"};
    topology.renderer.computer = {"n2"};
    return topology;
}

/// Four slabs of 1,000 primitives in four regions, one each.
const FrameWork frame = testing::frame_of(256, 256, 4, 1000);
constexpr double words = 4 * 1000 * testing::primitive_words;

const ClusterWork frame_alone{.picture = {0, {&frame}}};

double bytes_of(const Demand& demand, std::string_view name) {
    double sum = 0;
    for (const Phase& phase : demand) {
        for (const Sent& one : phase.sent) {
            sum += phase.name == name ? one.bytes : 0;
        }
    }
    return sum;
}

std::string refusal(const ClusterOptions& options) {
    try {
        cluster_of(options);
    } catch (const RequestError& error) {
        CHECK(error.code == ExitCode::usage);
        return error.what();
    }
    return "taken";
}

}  // namespace

TEST_SUITE("host/timing/cluster") {
    TEST_CASE("nodes are on the computers on which a machine that runs has them") {
        Cluster cluster = free_of_cost();
        const ClusterPlan plan = cluster_plan(apart(3, 2), cluster, 2);
        CHECK(plan.computer == std::vector<std::size_t>{0, 0, 0, 0, 1, 1, 0});
        cluster.host_apart = true;
        const ClusterPlan far = cluster_plan(apart(3, 2), cluster, 2);
        CHECK(far.computers == 3);
        CHECK(far.computer == std::vector<std::size_t>{2, 0, 0, 0, 1, 1, 2});
        Topology topology = apart(3, 2);
        topology.gp.computer.clear();
        topology.renderer.computer.clear();  // Five nodes on computers with four cores each.
        CHECK(cluster_plan(topology, free_of_cost(), 3).computer ==
              std::vector<std::size_t>{0, 0, 0, 1, 0, 0, 0});
    }

    TEST_CASE("a frame's words and pixels are sent once, whoever sends them") {
        for (const int gps : {1, 3, 7}) {
            for (const int renderers : {1, 2, 9}) {
                const ClusterPlan plan = cluster_plan(apart(gps, renderers), free_of_cost(), 2);
                const Demand demand = frame_demand(free_of_cost(), plan, frame);
                // Bodies have some bytes per message, region and segment beside the words.
                CHECK(bytes_of(demand, "bins") >= words * 4);
                CHECK(bytes_of(demand, "bins") <= words * 4 + gps * renderers * 80 + 4 * 64);
                CHECK(bytes_of(demand, "pixels") >= 4 * region_bytes);
                CHECK(bytes_of(demand, "pixels") <= 4 * region_bytes + renderers * 80 + 4 * 24);
            }
        }
    }

    TEST_CASE("copies of slabs are as many times the words, spread over the GPs") {
        const ClusterPlan plan = cluster_plan(apart(8, 2), free_of_cost(), 2);
        Cluster cluster = free_of_cost();
        cluster.gp_word_ns = 1000;
        const Demand demand = frame_demand(cluster, plan, frame, {2, 4});
        CHECK(bytes_of(demand, "bins") == doctest::Approx(2 * words * 4).epsilon(0.01));
        const Phase& bins = demand.at(3);
        CHECK(bins.name == "bins");
        for (std::size_t gp = 0; gp < 8; ++gp) {
            CHECK(bins.work_us[plan.gp(gp)] == doctest::Approx(words / 4).epsilon(near));
        }
    }

    TEST_CASE("the busiest direction of a link sets the rate") {
        const Cluster cluster = free_of_cost();
        const ClusterPlan plan = cluster_plan(apart(2, 2), cluster, 2);
        const ClusterTime time = cluster_time(cluster, plan, frame_alone);
        const Demand demand = frame_demand(cluster, plan, frame);
        // Bins and two BeginFrames go out of n1; pixels go in.
        const double out = bytes_of(demand, "bins") + 1000;
        CHECK(time.limit.unit == ClusterUnit::link);
        CHECK(time.frames_per_s == doctest::Approx(1e6 * 100 / out).epsilon(near));
        CHECK(time.network_bytes ==
              doctest::Approx(out + bytes_of(demand, "pixels")).epsilon(near));
        // One frame at a time: bins, then pixels, on the link.
        CHECK(time.latency_us ==
              doctest::Approx((out - 1000 + bytes_of(demand, "pixels")) / 100).epsilon(near));
        const Lever lever = best_lever(cluster, plan, frame_alone, false);
        CHECK(lever.change == "link.mbit 1600");
        CHECK(lever.gain == doctest::Approx(1).epsilon(near));
        Cluster fast = cluster;
        fast.link_mbit *= 2;
        CHECK(cluster_time(fast, plan, frame_alone).frames_per_s ==
              doctest::Approx(2 * time.frames_per_s).epsilon(near));
    }

    TEST_CASE("both directions of each link count, for themselves") {
        const Cluster cluster = free_of_cost();
        Topology out = apart(2, 2), in = apart(2, 2);
        out.renderer.computer = {"n2", "n3"};
        in.gp.computer = {"n2", "n3"};
        in.renderer.computer = {"n1"};
        for (const Topology& topology : {out, in}) {
            // All bins through the link of n1, half of them through each other link.
            const ClusterPlan plan = cluster_plan(topology, cluster, 3);
            const ClusterTime time = cluster_time(cluster, plan, frame_alone);
            CHECK(time.limit.unit == ClusterUnit::link);
            CHECK(time.limit.computer == 0);
            CHECK(time.limit.us == doctest::Approx(words * 4 / 100).epsilon(0.01));
        }
    }

    TEST_CASE("nothing crosses the network on one computer") {
        const Cluster cluster = free_of_cost();
        Topology topology = apart(2, 2);
        topology.renderer.computer = {"n1"};
        const ClusterPlan plan = cluster_plan(topology, cluster, 1);
        CHECK(cluster_time(cluster, plan, frame_alone).network_bytes == 0);
        CHECK(crossings(cluster, plan, frame_alone).empty());
    }

    TEST_CASE("the slowest node sets the rate, or all nodes of a computer with few cores") {
        Cluster cluster = free_of_cost();
        cluster.link_mbit = 1e7;
        cluster.renderer_word_ns = 10;
        const ClusterPlan plan = cluster_plan(apart(1, 2), cluster, 2);
        // Two of four equal regions each.
        const double renderer_us = words / 2 * 10 / 1000;
        ClusterTime time = cluster_time(cluster, plan, frame_alone);
        CHECK(time.limit.unit == ClusterUnit::renderer);
        CHECK(time.limit.computer == 1);
        CHECK(time.limit.us == doctest::Approx(renderer_us).epsilon(near));
        cluster.cores = 1;
        time = cluster_time(cluster, plan, frame_alone);
        CHECK(time.limit.unit == ClusterUnit::cores);
        CHECK(time.limit.us == doctest::Approx(2 * renderer_us).epsilon(near));
        cluster.core_speed = 4;
        CHECK(cluster_time(cluster, plan, frame_alone).limit.us ==
              doctest::Approx(renderer_us / 2).epsilon(near));
    }

    TEST_CASE("encryption costs both ends") {
        Cluster cluster = free_of_cost();
        cluster.link_mbit = 1e7;
        cluster.curve_byte_ns = 10;
        const ClusterPlan plan = cluster_plan(apart(1, 1), cluster, 2);
        CHECK(cluster_time(cluster, plan, frame_alone).limit.unit == ClusterUnit::link);
        cluster.curve = 1;
        cluster.frames_in_flight = 8;
        const ClusterTime time = cluster_time(cluster, plan, frame_alone);
        const Demand demand = frame_demand(cluster, plan, frame);
        CHECK(time.limit.unit == ClusterUnit::io_thread);
        // The Renderer's: bins in, pixels out, and BeginFrame.
        CHECK(time.limit.us ==
              doctest::Approx((bytes_of(demand, "bins") + bytes_of(demand, "pixels") + 500) / 100)
                  .epsilon(near));
    }

    TEST_CASE("compressed bodies are smaller on the network and cost both nodes") {
        Cluster cluster = free_of_cost();
        cluster.compress_byte_ns = 2;
        const ClusterPlan plan = cluster_plan(apart(1, 1), cluster, 2);
        const ClusterTime plain = cluster_time(cluster, plan, frame_alone);
        cluster.compress = 1;
        cluster.compress_bins = 0.5;
        cluster.compress_pixels = 0.25;
        const ClusterTime packed = cluster_time(cluster, plan, frame_alone);
        const Demand demand = frame_demand(cluster, plan, frame);
        const double bins = bytes_of(demand, "bins"), pixels = bytes_of(demand, "pixels");
        CHECK(plain.network_bytes == doctest::Approx(bins + pixels + 500).epsilon(near));
        CHECK(packed.network_bytes == doctest::Approx(bins / 2 + pixels / 4 + 500).epsilon(near));
        cluster.link_mbit = 1e7;
        cluster.frames_in_flight = 8;
        const ClusterTime fast = cluster_time(cluster, plan, frame_alone);
        CHECK(fast.limit.unit == ClusterUnit::renderer);
        CHECK(fast.limit.us == doctest::Approx((bins + pixels) * 2 / 1000).epsilon(near));
        // One after the other: the GP compresses, the Renderer restores and compresses, the frame
        // buffer restores.
        CHECK(fast.latency_us == doctest::Approx((bins + pixels) * 4 / 1000).epsilon(0.001));
    }

    TEST_CASE("frames in flight limit the rate where messages take long on their way") {
        Cluster cluster = free_of_cost();
        cluster.link_mbit = 1e7;
        cluster.round_trip_us = 1e6;
        cluster.frames_in_flight = 2;
        const ClusterPlan plan = cluster_plan(apart(1, 1), cluster, 2);
        const ClusterTime time = cluster_time(cluster, plan, frame_alone);
        // Half a round trip for bins, half for pixels. The host is with the GP.
        CHECK(time.latency_us == doctest::Approx(1e6).epsilon(1e-3));
        CHECK(time.limit.unit == ClusterUnit::in_flight);
        CHECK(time.frames_per_s == doctest::Approx(2).epsilon(1e-3));
        CHECK(best_lever(cluster, plan, frame_alone, false).gain ==
              doctest::Approx(1).epsilon(0.01));
    }

    TEST_CASE("many messages are named as the limit") {
        Cluster cluster = free_of_cost();
        cluster.link_mbit = 1e7;
        cluster.message_us = 100;
        cluster.frames_in_flight = 8;
        const ClusterPlan plan = cluster_plan(apart(40, 2), cluster, 2);
        const ClusterTime time = cluster_time(cluster, plan, frame_alone);
        CHECK(time.limit.unit == ClusterUnit::messages);
        // GP 0: the request, 39 GPs, 2 Renderers and the frame buffer begin, 2 bins. A Renderer has
        // 40 bins, begin and pixels.
        CHECK(time.limit.us == doctest::Approx(4500).epsilon(near));
    }

    TEST_CASE("a new isovalue is extracted before its frame is drawn") {
        Cluster cluster = free_of_cost();
        cluster.gp_slab_us = 1000;
        cluster.gp_triangle_ns = 500;
        const BuildWork build{0, 1, 0.5, {{0, 0, 0, 2000}, {1, 0, 0, 4000}, {2, 0, 0, 6000}}};
        const ClusterWork work{.picture = frame_alone.picture, .build = &build};
        const ClusterPlan plan = cluster_plan(apart(2, 2), cluster, 2);
        const ClusterTime time = cluster_time(cluster, plan, work);
        // GP 0 has slabs 0 and 2.
        CHECK(*time.isovalue_us - time.latency_us == doctest::Approx(6000).epsilon(near));
    }

    TEST_CASE("slices cross the link of the host to each GP that needs them") {
        Cluster cluster = free_of_cost();
        cluster.host_apart = true;
        const VolumeWork volume{"v", 100, 10, 5, 2, {}};
        const ClusterWork work{.picture = frame_alone.picture, .volume = &volume};
        const ClusterTime one = cluster_time(cluster, cluster_plan(apart(1, 1), cluster, 2), work);
        CHECK(one.load_network_bytes == 5 * 2000);
        CHECK(one.load_us == doctest::Approx(100).epsilon(near));
        // Four slabs: the slices 0 to 2, 0 to 3, 1 to 4 and 2 to 4.
        const ClusterTime four = cluster_time(cluster, cluster_plan(apart(4, 1), cluster, 2), work);
        CHECK(four.load_network_bytes == (3 + 4 + 4 + 3) * 2000);
    }

    TEST_CASE("passes of a picture take their turns") {
        const Cluster cluster = free_of_cost();
        const ClusterPlan plan = cluster_plan(apart(2, 2), cluster, 2);
        const ClusterWork twice{.picture = {0, {&frame, &frame}}};
        const ClusterTime one = cluster_time(cluster, plan, frame_alone);
        const ClusterTime two = cluster_time(cluster, plan, twice);
        CHECK(two.frames_per_s == doctest::Approx(one.frames_per_s / 2).epsilon(near));
        CHECK(two.latency_us == doctest::Approx(one.latency_us + one.limit.us).epsilon(near));
    }

    TEST_CASE("presets and settings change what they name, and refuse the rest") {
        const Cluster usual;
        ClusterOptions options;
        CHECK(options.is_empty());
        options.link = "25g";
        options.cores = 16;
        options.settings = {"curve=0", "gp.word_ns=1.5"};
        CHECK_FALSE(options.is_empty());
        const Cluster cluster = cluster_of(options);
        CHECK(cluster.link_mbit == 25'000);
        CHECK(cluster.cores == 16);
        CHECK(cluster.curve == 0);
        CHECK(cluster.gp_word_ns == 1.5);
        CHECK(cluster.renderer_word_ns == usual.renderer_word_ns);
        CHECK(refusal({.link = "token-ring"}) ==
              "--link token-ring: must be one of 1g, 10g, 25g, 100g, infiniband");
        CHECK(refusal({.link_mbit = 0}) == "link.mbit is 0 Mbit/s, must be 1 to 10000000");
        CHECK(refusal({.settings = {"curve"}}) == "--cluster-set curve: must be NAME=NUMBER");
        CHECK(refusal({.settings = {"curve=yes"}}) ==
              "--cluster-set curve=yes: must be NAME=NUMBER");
        CHECK(refusal({.settings = {"cores=nan"}}).find("must be 1 to 4096") != std::string::npos);
        CHECK(refusal({.settings = {"corse=1"}}).find("must be one of link.mbit, ") !=
              std::string::npos);
    }

    TEST_CASE("every parameter has its usual value, within its range, and a source") {
        const Cluster usual;
        for (const ClusterRow& row : cluster_rows()) {
            CAPTURE(row.name);
            CHECK(usual.*row.value == row.usual);
            CHECK(row.usual >= row.least);
            CHECK(row.usual <= row.most);
            CHECK_FALSE(row.source.empty());
        }
    }
}
