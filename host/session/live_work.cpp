#include "host/session/live_work.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

#include "host/base/error.hpp"
#include "host/timing/counts/runs.hpp"
#include "host/volume/reduced.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;
using namespace timing;

PartWork part_of(const schema::PartCounts& told) {
    PartWork part;
    part.region = told.region();
    part.kind = told.kind();
    part.surface = told.surface();
    part.slab = told.slab();
    part.primitives = told.primitives();
    part.words = told.words();
    part.port_cycles = told.port_cycles();
    part.backing_cycles = told.backing_cycles();
    for (std::uint16_t i = 0; i < part.classes.size(); ++i) {
        const schema::ClassCounts* counts = told.classes()->Get(i);
        part.classes.at(i) = {counts->instructions(), counts->cycles()};
    }
    return part;
}

FrameWork work_of(const CountedFrame& counted) {
    FrameWork work;
    work.frame = counted.frame;
    work.width = counted.width;
    work.height = counted.height;
    work.views = counted.views;
    work.reads_out = counted.pass.is_last();
    work.sample = static_cast<std::uint32_t>(counted.pass.sample);
    work.samples = static_cast<std::uint32_t>(counted.pass.samples);
    work.assignment = counted.region_renderers;
    for (const auto& [node, counts] : counted.counts) {
        for (const schema::DrawnSlab& slab : counts.drawn) {
            work.drawn.push_back({slab.surface(), slab.slab(), slab.primitives()});
        }
        std::ranges::transform(counts.parts, std::back_inserter(work.parts), part_of);
    }
    std::ranges::sort(work.drawn, {},
                      [](const DrawnSlab& slab) { return std::tuple(slab.surface, slab.slab); });
    // One Renderer has told all of a region, in order.
    std::ranges::stable_sort(work.parts, {}, &PartWork::region);
    return work;
}

}  // namespace

VolumeWork volume_work(const Session& session) {
    const Volume& volume = session.volumes.volume();
    require_all_voxels(volume, "the timing model");
    VolumeWork work;
    work.name = volume.name;
    work.nx = static_cast<std::uint32_t>(volume.nx);
    work.ny = static_cast<std::uint32_t>(volume.ny);
    work.nz = static_cast<std::uint32_t>(volume.nz);
    work.voxel_bytes = static_cast<std::uint32_t>(size_bytes(volume.type));
    work.gradient = volume.gradient;
    const std::size_t slice_bytes = std::size_t{work.nx} * work.ny * work.voxel_bytes;
    const std::span<const std::byte> values(volume.values);
    for (std::size_t z = 0; z < work.nz; ++z) {
        work.runs.push_back(runs_of(values.subspan(z * slice_bytes, slice_bytes),
                                    {work.nx, work.ny, work.voxel_bytes}));
    }
    return work;
}

BuildWork build_work(const Session& session, const std::string& surface) {
    const SurfaceReport& report = session.surfaces.report_of(surface);
    const Surface built = *session.surfaces.find(surface);
    if (report.slabs_left_out > 0) {
        throw RequestError(
            ExitCode::failed,
            fmt::format("surface {} has slabs that the GPs extract again for each frame, and the "
                        "model knows surfaces in memory only; give the GPs more memory "
                        "(gp.memory_mib), or use more GPs",
                        surface));
    }
    BuildWork work;
    work.surface = built.id;
    work.revision = built.revision;
    work.isovalue = built.isovalue;
    for (const schema::SlabCounts& slab : report.slabs) {
        work.slabs.push_back({slab.slab(), slab.cells_active(), slab.vertices(), slab.triangles()});
    }
    return work;
}

std::vector<FrameWork> frame_work(Session& session) {
    std::vector<FrameWork> work;
    std::ranges::transform(session.frames.draw_counted(), std::back_inserter(work), work_of);
    return work;
}

RunWork live_work(Session& session) {
    RunWork run;
    if (session.volumes.has_volume()) {
        run.steps.emplace_back(volume_work(session));
        for (const Surface& surface : session.scene.surfaces) {
            run.steps.emplace_back(build_work(session, surface.name));
        }
    }
    for (FrameWork& frame : frame_work(session)) {
        run.steps.emplace_back(std::move(frame));
    }
    return run;
}

}  // namespace pxpl5::host
