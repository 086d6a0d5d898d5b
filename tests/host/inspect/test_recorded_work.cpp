// The work that is read out of a recording is what was asked for, whoever did it.
#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/inspect/listing/run_stats.hpp"
#include "host/inspect/model/recorded_work.hpp"
#include "host/phantom/phantom.hpp"
#include "host/session/live_work.hpp"
#include "host/timing/counts/runs.hpp"
#include "tests/host/inspect/recorded_sphere.hpp"
#include "tests/host/inspect/recorded_surface.hpp"

using namespace pxpl5;
namespace inspect = host::inspect;
namespace schema = bus::schema;
using bus::Body;
using host::timing::BuildWork;
using host::timing::FrameWork;
using host::timing::RunWork;
using host::timing::VolumeWork;

namespace {

template <typename Step>
std::vector<Step> all(const RunWork& work) {
    std::vector<Step> steps;
    for (const host::timing::StepWork& step : work.steps) {
        if (const Step* one = std::get_if<Step>(&step)) {
            steps.push_back(*one);
        }
    }
    return steps;
}

template <typename List, typename Count>
std::uint64_t sum(const List& list, const Count& count) {
    return std::accumulate(list.begin(), list.end(), std::uint64_t{0},
                           [&](std::uint64_t n, const auto& one) { return n + count(one); });
}

std::uint64_t primitives_of(const FrameWork& frame) {
    return sum(frame.drawn, [](const auto& slab) { return slab.primitives; });
}

/// Frames as if one Renderer had drawn them.
RunWork without_assignments(RunWork work) {
    for (host::timing::StepWork& step : work.steps) {
        if (auto* frame = std::get_if<FrameWork>(&step)) {
            std::ranges::fill(frame->assignment, 0);
        }
    }
    return work;
}

template <typename Lost>
void lose(std::vector<inspect::NodeTrace>& traces, schema::Role role, const Lost& is_lost) {
    for (inspect::NodeTrace& node : traces) {
        if (node.info.role == role) {
            std::erase_if(node.entries, is_lost);
        }
    }
}

auto of_kind(Body kind) {
    return [kind](const bus::trace::Entry& entry) { return entry.kind() == kind; };
}

bool holds(const std::vector<std::string>& sentences, const std::string& text) {
    return std::ranges::any_of(sentences, [&](const std::string& sentence) {
        return sentence.find(text) != std::string::npos;
    });
}

/// Several volumes, surfaces and ways of drawing, one after the other.
void use(host::Session& session) {
    session.scene.size = {150, 140};
    session.volumes.load("phantom:letters");
    const double middle = (session.volumes.volume().minimum + session.volumes.volume().maximum) / 2;
    session.surfaces.set("outer", middle, CaseRule::watertight, {200, 180, 160});
    session.frames.draw();
    session.surfaces.set("inner", middle * 1.2, CaseRule::lorensen1987, {90, 120, 160});
    host::Surface thin = *session.surfaces.find("outer");
    thin.opacity = 6;
    thin.cull_back = true;
    session.surfaces.set_style(thin);
    session.scene.samples = 4;
    session.frames.draw();
    session.scene.samples = 1;
    test::set_up_sphere(session, {150, 140});
    session.frames.draw();
}

RunWork work_with(int gps, int renderers) {
    test::RecordedMachine recorded(test::machine_of(gps, renderers));
    use(recorded.session);
    return inspect::recorded_work(recorded.run());
}

}  // namespace

TEST_CASE("a volume is its shape and its slices' runs") {
    test::TracedSphere sphere({130, 100}, 3, 2);
    const RunWork work = inspect::recorded_work(sphere.run());
    CHECK(work.missing.empty());
    REQUIRE(work.steps.size() == 3);
    const auto& loaded = std::get<VolumeWork>(work.steps[0]);
    const host::Volume volume = host::make_phantom("phantom:sphere");
    CHECK(loaded.name == volume.name);
    CHECK(loaded.nx == static_cast<std::uint32_t>(volume.nx));
    CHECK(loaded.ny == static_cast<std::uint32_t>(volume.ny));
    CHECK(loaded.nz == static_cast<std::uint32_t>(volume.nz));
    REQUIRE(loaded.runs.size() == loaded.nz);
    const std::size_t slice_bytes = volume.values.size() / loaded.nz;
    CHECK(loaded.voxel_bytes == slice_bytes / loaded.nx / loaded.ny);
    for (std::size_t z = 0; z < loaded.nz; ++z) {
        CHECK(loaded.runs[z] ==
              host::timing::runs_of(
                  std::as_bytes(std::span(volume.values)).subspan(z * slice_bytes, slice_bytes),
                  {loaded.nx, loaded.ny, loaded.voxel_bytes}));
    }
}

TEST_CASE("a recorded volume has the gradient kernel that it was loaded with") {
    test::RecordedMachine recorded(test::machine_of(2, 1));
    host::ImportOptions options;
    options.gradient = GradientKernel::smooth;
    recorded.session.volumes.load("phantom:sphere", options);
    const host::timing::VolumeWork live = host::volume_work(recorded.session);
    CHECK(live.gradient == GradientKernel::smooth);
    const RunWork work = inspect::recorded_work(recorded.run());
    REQUIRE(work.steps.size() == 1);
    CHECK(std::get<VolumeWork>(work.steps[0]) == live);
}

TEST_CASE("a build is what the surface's report tells, slab by slab") {
    test::RecordedMachine recorded(test::machine_of(3, 2));
    test::set_up_sphere(recorded.session, {130, 100});
    const host::SurfaceReport report = recorded.session.surfaces.report_of("ball");
    const RunWork work = inspect::recorded_work(recorded.run());
    REQUIRE(work.steps.size() == 2);
    const auto& build = std::get<BuildWork>(work.steps[1]);
    CHECK(build.isovalue == 100);
    CHECK(build.slabs.size() == static_cast<std::size_t>(recorded.session.volumes.volume().nz - 1));
    for (std::size_t k = 0; k < build.slabs.size(); ++k) {
        CHECK(build.slabs[k].slab == k);
    }
    const auto total = [&](std::uint64_t host::timing::SlabWork::*count) {
        return sum(build.slabs, [&](const auto& slab) { return slab.*count; });
    };
    CHECK(report.triangles > 0);
    CHECK(total(&host::timing::SlabWork::triangles) ==
          static_cast<std::uint64_t>(report.triangles));
    CHECK(total(&host::timing::SlabWork::vertices) == static_cast<std::uint64_t>(report.vertices));
    CHECK(total(&host::timing::SlabWork::cells_active) ==
          static_cast<std::uint64_t>(report.cells_active));
}

TEST_CASE("a frame is what its Renderers told, region by region") {
    test::RecordedMachine recorded(test::machine_of(2, 3));
    test::set_up_sphere(recorded.session, {300, 140});
    recorded.session.frames.draw();
    const host::FrameReport& told = recorded.session.frames.last();
    const RunWork work = inspect::recorded_work(recorded.run());
    const FrameWork frame = all<FrameWork>(work).at(0);
    CHECK(frame.frame == told.frame);
    CHECK(frame.width == 300);
    CHECK(frame.height == 140);
    CHECK(frame.views == 1);
    CHECK(frame.reads_out);
    CHECK(frame.assignment == told.region_renderers);
    REQUIRE(frame.regions() == 6);
    std::vector<std::uint64_t> cycles(frame.regions());
    std::uint64_t instructions = 0;
    for (const host::timing::PartWork& part : frame.parts) {
        cycles.at(part.region) += part.cycles();
        instructions += sum(part.classes, [](const auto& count) { return count.instructions; });
    }
    CHECK(cycles == told.region_cycles);
    CHECK(instructions == static_cast<std::uint64_t>(told.instructions));
    CHECK(primitives_of(frame) ==
          static_cast<std::uint64_t>(recorded.session.surfaces.report_of("ball").triangles));
}

TEST_CASE("a region begins with its prologue, ends by sending 24 bits of 16,384 pixels") {
    test::TracedSphere sphere({130, 100}, 2, 1);
    const inspect::RecordedRun run = sphere.run();
    const RunWork work = inspect::recorded_work(run);
    const FrameWork frame = all<FrameWork>(work).at(0);
    const inspect::RecordedFrame recorded = run.frame(0);
    std::uint64_t words = 0;
    for (std::size_t i = 0; i < frame.parts.size(); ++i) {
        const host::timing::PartWork& part = frame.parts[i];
        const bool first = i == 0 || frame.parts[i - 1].region != part.region;
        const bool last = i + 1 == frame.parts.size() || frame.parts[i + 1].region != part.region;
        CHECK((part.kind == PartKind::prologue) == first);
        CHECK((part.kind == PartKind::end_of_region) == last);
        CHECK(part.port_cycles == (last ? 16'384 + 24 : 0));
        CHECK(part.backing_cycles == 0);
        words += part.words;
    }
    std::uint64_t sent = 0;
    for (const auto& [gp, message] : recorded.inputs.at(0).programs) {
        for (const auto* program : *message.as<schema::RegionPrograms>()->regions()) {
            sent += program->words()->size();
        }
    }
    CHECK(words == sent);
    CHECK(sent > 0);
}

TEST_CASE("the same commands are the same work for any number of GPs and Renderers") {
    const RunWork one = work_with(1, 1);
    CHECK(one.missing.empty());
    // Two loads, three surfaces, and frames: one, four passes, one.
    REQUIRE(one.steps.size() == 2 + 3 + 6);
    const std::vector<FrameWork> frames = all<FrameWork>(one);
    CHECK(!frames[1].reads_out);
    CHECK(frames[4].reads_out);
    CHECK(sum(frames[4].parts, [](const auto& part) { return part.backing_cycles; }) > 0);
    CHECK(sum(frames[1].parts,
              [](const auto& part) { return part.kind == PartKind::shut_door ? 1 : 0; }) > 0);
    const RunWork expected = without_assignments(one);
    for (const auto& [gps, renderers] : {std::pair(3, 2), std::pair(7, 5)}) {
        const RunWork other = work_with(gps, renderers);
        CHECK(other.missing.empty());
        CHECK(without_assignments(other).steps == expected.steps);
        CHECK(other.steps != expected.steps);  // Only the assignments differ, and they do.
    }
}

TEST_CASE("primitives count once a view, masked ones too, and only slabs that are drawn") {
    host::Volume volume = host::make_phantom("phantom:sphere");
    volume.gap_slabs = {30, 31};
    test::RecordedSurface recorded(volume, 2, 1);
    recorded.add_surface(100);
    const host::Camera camera{{30, 5}, 1.0};
    recorded.draw(camera, 100, 100);
    recorded.draw(camera, 100, 100, [](schema::DrawFrameT& draw) {
        draw.views.push_back(std::make_unique<schema::ViewT>(*draw.views.front()));
    });
    for (const auto choice : {SlabChoice::in_gaps, SlabChoice::outside_gaps}) {
        recorded.draw(camera, 100, 100, [choice](schema::DrawFrameT& draw) {
            draw.surfaces.front().mutate_slabs(choice);
        });
    }
    recorded.mask([](std::uint32_t slab, std::size_t triangle) {
        return slab % 3 == 0 || triangle % 2 == 0;
    });
    recorded.draw(camera, 100, 100);
    const RunWork work = inspect::recorded_work(recorded.run());
    CHECK(work.missing.empty());
    const BuildWork build = all<BuildWork>(work).at(0);
    const std::vector<FrameWork> frames = all<FrameWork>(work);
    REQUIRE(frames.size() == 5);
    const std::uint64_t triangles =
        sum(build.slabs, [](const auto& slab) { return slab.triangles; });
    const std::uint64_t in_gaps = build.slabs[30].triangles + build.slabs[31].triangles;
    CHECK(primitives_of(frames[0]) == triangles);
    CHECK(primitives_of(frames[1]) == 2 * triangles);
    CHECK(frames[1].views == 2);
    CHECK(in_gaps > 0);
    CHECK(primitives_of(frames[2]) == in_gaps);
    CHECK(primitives_of(frames[3]) == triangles - in_gaps);
    CHECK(primitives_of(frames[4]) == triangles);
    CHECK(std::ranges::all_of(frames[0].drawn, [](const auto& s) { return s.primitives > 0; }));
}

TEST_CASE("a scene's frames are counted, and there is nothing to build") {
    const auto work_of = [](int gps, int renderers) {
        test::RecordedMachine recorded(test::machine_of(gps, renderers));
        recorded.session.scene.size = {150, 140};
        recorded.session.volumes.load(std::string(PXPL5_SOURCE_DIR) +
                                      "/host/phigs/archives/molecule.phigs");
        recorded.session.frames.draw();
        return inspect::recorded_work(recorded.run());
    };
    const RunWork work = work_of(2, 1);
    CHECK(work.missing.empty());
    REQUIRE(work.steps.size() == 1);
    const FrameWork frame = all<FrameWork>(work).at(0);
    CHECK(primitives_of(frame) > 0);
    CHECK(without_assignments(work_of(5, 3)).steps == without_assignments(work).steps);
}

TEST_CASE("slabs that a flight recorder no longer has the counts of are extracted again") {
    test::TracedSphere sphere({130, 100}, 3, 2);
    const RunWork whole = inspect::recorded_work(sphere.run());
    std::vector<inspect::NodeTrace> traces = sphere.traces();
    lose(traces, schema::Role::host, of_kind(Body::SurfaceBuilt));
    for (inspect::NodeTrace& node : traces) {
        node.info.recording = Recording::flight;
    }
    const RunWork again = inspect::recorded_work(inspect::RecordedRun(traces));
    CHECK(again.missing.empty());
    CHECK(again.steps == whole.steps);
}

TEST_CASE("a surface that was given up for another is not counted, and that is said") {
    test::TracedSphere sphere({130, 100}, 3, 2);
    std::vector<inspect::NodeTrace> traces = sphere.traces();
    bool lost = false;
    lose(traces, schema::Role::host, [&](const bus::trace::Entry& entry) {
        return entry.kind() == Body::SurfaceBuilt && !std::exchange(lost, true);
    });
    const RunWork work = inspect::recorded_work(inspect::RecordedRun(traces));
    CHECK(all<BuildWork>(work).empty());
    CHECK(all<FrameWork>(work).empty());  // Its slabs are not known either.
    CHECK(holds(work.missing, "surface 0, revision 1: a newer revision replaced it after "));
    CHECK(holds(work.missing, "frame 0: GPs told of "));
}

TEST_CASE("voxels that are gone are those of the phantom, or else the volume is missing") {
    test::TracedSphere sphere({130, 100}, 2, 1);
    const RunWork whole = inspect::recorded_work(sphere.run());
    std::vector<inspect::NodeTrace> traces = sphere.traces();
    lose(traces, schema::Role::gp, of_kind(Body::Slices));
    const RunWork built = inspect::recorded_work(inspect::RecordedRun(traces));
    CHECK(built.missing.empty());
    CHECK(built.steps == whole.steps);

    test::change<schema::VolumeHeader>(
        traces, [](schema::VolumeHeaderT& header) { header.source = "/scans/ball.nrrd"; });
    const RunWork file = inspect::recorded_work(inspect::RecordedRun(traces));
    CHECK(holds(file.missing, "'/scans/ball.nrrd', which is not read again"));
    CHECK(all<BuildWork>(file).empty());  // None without its volume.
    CHECK(all<FrameWork>(file) == all<FrameWork>(whole));
}

TEST_CASE("a frame with a region that cannot be executed again is missing as a whole") {
    test::TracedSphere sphere({300, 100}, 2, 2);
    std::vector<inspect::NodeTrace> traces = sphere.traces();
    std::erase_if(traces, [](const inspect::NodeTrace& node) {
        return node.info.role == schema::Role::renderer && node.info.index == 1;
    });
    const RunWork work = inspect::recorded_work(inspect::RecordedRun(traces));
    CHECK(all<BuildWork>(work).size() == 1);
    CHECK(all<FrameWork>(work).empty());
    CHECK(holds(work.missing, "frame 0: renderer-1: no BeginFrame"));
}

TEST_CASE("frames that are not selected are left out, silently") {
    test::RecordedMachine recorded(test::machine_of(1, 1));
    test::set_up_sphere(recorded.session, {100, 100});
    for (int i = 0; i < 3; ++i) {
        recorded.session.frames.draw();
    }
    const RunWork work = inspect::recorded_work(recorded.run(), {{1, 1}});
    CHECK(work.missing.empty());
    CHECK(work.steps.size() == 3);
    CHECK(all<FrameWork>(work).at(0).frame == 1);
}

TEST_CASE("a picture's passes are selected together") {
    test::RecordedMachine recorded(test::machine_of(1, 1));
    test::set_up_sphere(recorded.session, {100, 100});
    recorded.session.frames.draw();
    recorded.session.scene.samples = 4;
    recorded.session.frames.draw();
    recorded.session.frames.draw();
    const inspect::RecordedRun run = recorded.run();
    for (const std::uint32_t named : {1, 2, 4}) {
        const std::vector<FrameWork> frames =
            all<FrameWork>(inspect::recorded_work(run, {{named, named}}));
        REQUIRE(frames.size() == 4);
        for (std::uint32_t sample = 0; sample < 4; ++sample) {
            CHECK(frames[sample].frame == 1 + sample);
            CHECK(frames[sample].sample == sample);
            CHECK(frames[sample].samples == 4);
        }
    }
    CHECK(all<FrameWork>(inspect::recorded_work(run, {{0, 0}})).size() == 1);
}

TEST_CASE("without the trace of GP 0 nobody knows what was asked for") {
    test::TracedSphere sphere({100, 100}, 2, 1);
    std::vector<inspect::NodeTrace> traces = sphere.traces();
    std::erase_if(traces, [](const inspect::NodeTrace& node) {
        return node.info.role == schema::Role::gp && node.info.index == 0;
    });
    const std::size_t left = traces.size();
    CHECK_THROWS_WITH_AS(
        inspect::recorded_work(inspect::RecordedRun(traces)),
        ("the trace of gp-0, which receives all requests of the host, is not among " +
         std::to_string(left) + " traces")
            .c_str(),
        host::RequestError);
}
