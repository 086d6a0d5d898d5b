// Scaling over computers: where it ends, and one set of numbers in text, fields and plots.
#include <doctest/doctest.h>

#include <fmt/format.h>

#include <string>
#include <variant>
#include <vector>

#include "host/report/cluster_scaling.hpp"
#include "tests/host/timing/cases.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::report;

namespace {

/// 64 slabs of equal work in 64 regions, on computers with one GP and one Renderer each.
timing::PaperCase even_case() {
    timing::PaperCase made = timing::testing::small_case(8, 100, 100);
    made.volume.nz = 65;
    made.build.slabs.clear();
    for (std::uint32_t slab = 0; slab < 64; ++slab) {
        made.build.slabs.push_back({slab, 50, 50, 100});
    }
    made.frame = timing::testing::frame_of(1024, 1024, 64, 1000);
    return made;
}

/// Computers whose network costs nothing.
timing::Cluster free_network() {
    timing::Cluster cluster;
    cluster.cores = 2;
    cluster.link_mbit = 1e7;
    cluster.round_trip_us = cluster.message_us = cluster.tcp_byte_ns = cluster.curve = 0;
    cluster.frame_buffer_region_us = cluster.host_region_us = 0;
    cluster.frames_in_flight = 64;
    cluster.compress_bins = cluster.compress_pixels = 1;
    return cluster;
}

ClusterScaling scaling_with(const timing::Cluster& cluster) {
    Topology topology;
    topology.frame_buffer.count = 1;
    topology.cluster.placement = Placement::spread;
    const std::uint32_t nodes = nodes_per_computer(cluster);
    return {cluster, nodes, nodes, {cluster_scaling_of(topology, cluster, "even", even_case())}};
}

const FieldValue& value(const Fields& fields, std::string_view name) {
    const auto found = std::ranges::find(fields, name, &Field::name);
    REQUIRE_MESSAGE(found != fields.end(), name);
    return found->value;
}

}  // namespace

TEST_SUITE("host/report/cluster_scaling") {
    TEST_CASE("growth ends where doubling gains little, or at half the rate of one computer") {
        CHECK(end_of_growth({1, 2, 4}, false) == std::nullopt);
        CHECK(end_of_growth({1, 2, 2.05, 4}, false) == 1);
        CHECK(end_of_growth({1, 0.2, 0.1}, false) == 0);
        CHECK(end_of_growth({1, 0.9, 0.5}, true) == std::nullopt);
        CHECK(end_of_growth({1, 0.9, 0.49, 0.3}, true) == 1);
        CHECK(end_of_growth({1, 0.4}, true) == 0);
    }

    TEST_CASE("without a network, work scales as far as there are slabs and regions") {
        const ClusterScaling scaling = scaling_with(free_network());
        const ClusterSeries& strong = scaling.rows[0].strong;
        REQUIRE(strong.points.size() == 9);
        CHECK(strong.points.back().computers == 256);
        const std::vector<double> frames = strong.relative(&ClusterPoint::frames);
        for (std::size_t i = 0; i <= 6; ++i) {
            CHECK(frames[i] == doctest::Approx(1 << i).epsilon(0.05));
        }
        CHECK(frames[7] == doctest::Approx(frames[6]).epsilon(0.01));
        CHECK(end_of_growth(frames, false) == 6);
        CHECK(strong.points[7].frames.limit == timing::ClusterUnit::renderer);
        // One region per Renderer, with the words of 256 slabs instead of one.
        const timing::Cluster& cluster = scaling.cluster;
        const double words_us =
            1000 * timing::testing::primitive_words * cluster.renderer_word_ns / 1000;
        const double region_us = cluster.renderer_region_us + cluster.renderer_shaded_us;
        CHECK(strong.points[8].frames.per_s / scaling.rows[0].weak.points[8].frames.per_s ==
              doctest::Approx((region_us + 256 * words_us) / (region_us + words_us)).epsilon(0.01));
    }

    TEST_CASE("a computer has half its cores as nodes of a kind, and all have 1,024 at most") {
        timing::Cluster cluster;
        for (const auto& [cores, nodes] : {std::pair{1, 1U}, {2, 1U}, {9, 4U}, {128, 64U}}) {
            cluster.cores = cores;
            CHECK(nodes_per_computer(cluster) == nodes);
        }
        CHECK(nodes_on(16, 64) == 1024);
        CHECK(nodes_on(32, 64) == 1024);
        CHECK(nodes_on(15, 64) == 960);
        cluster.cores = 128;
        const ClusterScaling scaling = scaling_with(cluster);
        CHECK(std::get<std::int64_t>(value(fields_of(scaling)[8], "gps")) == 1024);
    }

    TEST_CASE("a slow network ends it, and a faster one is what helps") {
        timing::Cluster cluster = free_network();
        cluster.link_mbit = 100;
        cluster.gp_slab_us = 1e6;  // A new isovalue takes far longer than its frame.
        const ClusterScaling scaling = scaling_with(cluster);
        const ClusterSeries& strong = scaling.rows[0].strong;
        CHECK(strong.points[1].frames.limit == timing::ClusterUnit::link);
        CHECK(strong.frames_lever.change == "link.mbit 200");
        CHECK(strong.frames_lever.gain > 0.9);
        CHECK(strong.thresholds_lever.change == "core.speed 2");
        const std::string text = text_of(scaling);
        CHECK(text.find("frames: no faster with more computers; limit with 2: link; link.mbit 200 "
                        "moves it most") != std::string::npos);
        CHECK(text.find("more than 64 computers are a forecast") != std::string::npos);
    }

    TEST_CASE("text, fields and plots have the same numbers") {
        const ClusterScaling scaling = scaling_with(free_network());
        const std::string text = text_of(scaling);
        const std::vector<Fields> lines = fields_of(scaling), ends = ends_of(scaling);
        const std::vector<Plot> plots = plots_of(scaling);
        REQUIRE(lines.size() == 18);
        REQUIRE(ends.size() == 4);
        REQUIRE(plots.size() == 4);
        for (std::size_t i = 0; i < lines.size(); ++i) {
            const bool is_weak = i >= 9;
            CHECK(std::get<std::string>(value(lines[i], "scaling")) ==
                  (is_weak ? "weak" : "strong"));
            for (const bool of_thresholds : {false, true}) {
                const double relative = std::get<double>(
                    value(lines[i], of_thresholds ? "thresholds_relative" : "frames_relative"));
                CHECK(text.find(fmt::format("{:.2f}", relative)) != std::string::npos);
                const auto& plot =
                    std::get<LinePlot>(plots[(is_weak ? 2U : 0U) + (of_thresholds ? 1U : 0U)]);
                CHECK(plot.lines[0].points[i % 9].y == relative);
            }
        }
        const auto ringed = std::get<LinePlot>(plots[0]).lines[0].ringed;
        REQUIRE(ringed.has_value());
        CHECK(std::get<bool>(value(ends[0], "ends")));
        CHECK(std::get<std::int64_t>(value(ends[0], "computers")) == std::int64_t{1} << *ringed);
        CHECK(text.find(fmt::format("with {} computers as with one, where it saturates",
                                    std::size_t{1} << *ringed)) != std::string::npos);
    }
}
