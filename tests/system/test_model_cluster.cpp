// The messages of the model of several computers are those that a recorded run has sent.
#include <doctest/doctest.h>

#include <map>
#include <string>

#include "host/base/error.hpp"
#include "host/inspect/model/model_cluster.hpp"
#include "host/inspect/model/recorded_work.hpp"
#include "tests/host/inspect/recorded_sphere.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using bus::Body;

namespace {

/// Computer of a node: GPs on n1, Renderers on n2, the rest on a third.
std::size_t computer_of(const inspect::RecordedRun& run, bus::NodeId id) {
    const std::string name = run.node_name(id);
    return name.starts_with("gp") ? 0 : name.starts_with("renderer") ? 1 : 2;
}

struct Sum {
    double messages = 0, bytes = 0;
};

/// Bytes that a recording adds to bins.
double bytes_of_origins(const bus::Message& message) {
    double bytes = 0;
    if (const auto* programs = message.as<bus::schema::RegionPrograms>()) {
        for (const auto* region : *programs->regions()) {
            bytes += region->origins() == nullptr ? 0
                                                  : static_cast<double>(region->origins()->size()) *
                                                        sizeof(bus::schema::Origin);
        }
    }
    return bytes;
}

/// Bodies of messages of these kinds between computers, as they are without a recording.
Sum recorded(const inspect::RecordedRun& run, std::size_t from, std::size_t to,
             std::initializer_list<Body> kinds) {
    Sum sum;
    for (const auto& [id, node] : run.nodes()) {
        for (const bus::trace::Entry& entry : node.entries) {
            if (std::ranges::find(kinds, entry.kind()) != kinds.end() &&
                computer_of(run, entry.header.source()) == from && computer_of(run, id) == to) {
                ++sum.messages;
                sum.bytes += static_cast<double>(entry.header.body_bytes()) -
                             bytes_of_origins(node.load(entry));
            }
        }
    }
    return sum;
}

inspect::ModelledCluster modelled(const inspect::RecordedRun& run, const std::string& computers) {
    Topology topology =
        test::machine_of(static_cast<int>(run.gp_count()), static_cast<int>(run.renderer_count()));
    topology.gp.computer = {"n1"};
    topology.renderer.computer = {"n2"};
    timing::Cluster cluster;
    cluster.host_apart = true;
    return inspect::modelled_cluster(topology, cluster, computers, inspect::recorded_work(run));
}

}  // namespace

TEST_CASE("messages between computers are those of the recording") {
    test::TracedSphere sphere({400, 300}, 3, 2);
    const inspect::RecordedRun run = sphere.run();
    std::map<std::string, Sum> expected = {
        {"bins 0 1", recorded(run, 0, 1, {Body::RegionPrograms})},
        {"begin 0 1", recorded(run, 0, 1, {Body::BeginFrame})},
        {"begin 0 2", recorded(run, 0, 2, {Body::BeginFrame})},
        {"pixels 1 2", recorded(run, 1, 2, {Body::RegionPixels})},
        {"request 2 0", recorded(run, 2, 0, {Body::DrawFrame})},
        {"slices 2 0", recorded(run, 2, 0, {Body::Slices})}};
    const inspect::ModelledCluster model = modelled(run, "2");
    CHECK(model.crossings.size() == expected.size());
    for (const timing::Crossing& one : model.crossings) {
        const std::string name =
            std::string(one.name) + " " + std::to_string(one.from) + " " + std::to_string(one.to);
        CAPTURE(name);
        REQUIRE(expected.contains(name));
        const Sum& sum = expected.at(name);
        if (one.name == "slices") {  // Several slices travel as one message, or one as several.
            CHECK(one.bytes == doctest::Approx(sum.bytes).epsilon(0.05));
            continue;
        }
        CHECK(one.messages == sum.messages);
        const double most_error = one.name == "bins" || one.name == "pixels" ? 0.005 : 0.3;
        CHECK(one.bytes == doctest::Approx(sum.bytes).epsilon(most_error));
    }
}

TEST_CASE("a number of computers is 1 to 256, and the run needs a picture") {
    test::TracedSphere sphere({200, 100}, 2, 1);
    const inspect::RecordedRun run = sphere.run();
    CHECK(modelled(run, "2..8*2").points.size() == 3);
    for (const char* wrong : {"0", "257", "two", "2..", "3.5"}) {
        CAPTURE(wrong);
        CHECK_THROWS_AS(modelled(run, wrong), RequestError);
    }
    timing::RunWork none = inspect::recorded_work(run);
    none.steps.pop_back();
    CHECK_THROWS_WITH_AS(inspect::modelled_cluster(test::machine_of(2, 1), {}, "2", none),
                         "--cluster times a frame, and none could be counted", RequestError);
}

TEST_CASE("text, JSON and CSV of a cluster have the same numbers") {
    test::TracedSphere sphere({200, 100}, 2, 1);
    const Answer answer = answer_of(modelled(sphere.run(), "2,3"));
    const std::string text = answer.text(), csv = answer.csv();
    const std::string json = json_text(answer.fields());
    const inspect::ModelledCluster model = modelled(sphere.run(), "2,3");
    for (const inspect::ModelledComputers& point : model.points) {
        const std::string rate = fixed_cell(point.time.frames_per_s, 1).text;
        CHECK(text.find(rate) != std::string::npos);
        const Fields line = {{"x", point.time.frames_per_s}};
        const std::string number = csv_line(line).substr(0, csv_line(line).size() - 1);
        CHECK(json.find("\"frames_per_s\":" + number) != std::string::npos);
        CHECK(csv.find("," + number + ",") != std::string::npos);
    }
    for (const timing::ClusterRow& row : timing::cluster_rows()) {
        CHECK(text.find(row.source) != std::string::npos);
        CHECK(json.find(std::string(row.source)) != std::string::npos);
    }
}
