#include "renderer_firmware/node_frame.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <map>

#include "ringbus/rules/slice_planes.hpp"

namespace pxpl5::renderer {

namespace {

namespace schema = bus::schema;
using schema::FaultCode;

/// Adds the segments of one GP for one region to the segments of the plan.
void take_region(FramePlan& plan, std::uint32_t surfaces, std::uint32_t gp,
                 const schema::RegionProgram& program) {
    const auto region =
        std::find_if(plan.regions.begin(), plan.regions.end(),
                     [&](const FramePlan::Region& r) { return r.number == program.region(); });
    if (region == plan.regions.end()) {
        plan.faults.push_back(
            {FaultCode::bad_message, gp,
             fmt::format("GP {}: region {} is not this Renderer's", gp, program.region())});
        return;
    }
    const Words words(program.words()->data(), program.words()->size());
    for (const schema::Segment* s : *program.segments()) {
        // Message has checked that segments are within the words.
        assert(std::size_t{s->first_word()} + s->word_count() <= words.size());
        if (s->surface() >= surfaces) {
            plan.faults.push_back(
                {FaultCode::bad_message, gp,
                 fmt::format("{}: the frame has {} surfaces",
                             place_of(gp, region->number, s->surface(), s->slab()), surfaces)});
        } else {
            region->segments.push_back({s->surface(), s->slab(), gp,
                                        words.subspan(s->first_word(), s->word_count()),
                                        s->first_word()});
        }
    }
}

/// A surface that appears several times in the list, with different slabs, has one pattern.
std::vector<Screen> screens_of(const schema::DrawFrame& draw) {
    std::vector<Screen> screens;
    std::map<std::uint16_t, std::uint32_t> patterns;  // Pattern by surface id.
    for (const schema::SurfaceDraw* surface : *draw.surfaces()) {
        Screen& screen = screens.emplace_back();
        screen.opacity = surface->opacity();
        if (screen.opacity < full_opacity) {
            const auto next = static_cast<std::uint32_t>(patterns.size());
            screen.pattern = patterns.try_emplace(surface->surface(), next).first->second;
        }
    }
    return screens;
}

}  // namespace

Shading shading_of(const schema::DrawFrame& draw) {
    Shading shading;
    for (const schema::Light* light : *draw.lights()) {
        const schema::Vec3& d = light->direction();
        shading.lights.push_back({{d.x(), d.y(), d.z()}, light->intensity()});
    }
    shading.screens = screens_of(draw);
    shading.pass = {draw.sample(), draw.samples()};
    for (const schema::SurfaceDraw* surface : *draw.surfaces()) {
        const schema::Rgb& c = surface->color();
        shading.surfaces.push_back({c.r(), c.g(), c.b()});
        shading.rims.push_back(static_cast<float>(surface->rim()) / max_rim);
    }
    shading.planes = bus::plane_count(draw);
    shading.ambient = draw.ambient();
    shading.specular = draw.specular();
    shading.specular_power = draw.specular_power();
    if (const schema::Rgb* c = draw.background()) {
        shading.background = {c->r(), c->g(), c->b()};
    }
    return shading;
}

std::string place_of(std::uint32_t gp, std::uint32_t region, std::uint32_t surface,
                     std::uint32_t slab) {
    return fmt::format("GP {}, region {}, surface {}, slab {}", gp, region, surface, slab);
}

RegionFrame region_frame(const RegionPrograms& programs) {
    RegionFrame frame{programs.prologue, programs.end_of_region};
    for (const DoorPrograms& door : programs.doors) {
        frame.doors.push_back({door.surface, door.shut, door.open});
    }
    frame.depths = programs.depths;
    check_own(frame);
    return frame;
}

FramePlan plan_frame(const FrameMessages& messages, std::uint32_t renderer) {
    const auto& begin = *messages.begin->as<schema::BeginFrame>();
    FramePlan plan;
    plan.frame = begin.draw()->frame();
    plan.counts = begin.draw()->counts();
    const Shading shading = shading_of(*begin.draw());
    plan.pass = shading.pass;
    plan.programs = region_programs(shading, begin.draw()->read_depths());
    const auto& assignment = *begin.assignment();
    for (std::uint32_t r = 0; r < assignment.size(); ++r) {
        if (assignment[r] == renderer) {
            plan.regions.push_back({r, {}});
        }
    }
    for (const auto& [gp, message] : messages.programs) {
        const auto& programs = *message.as<schema::RegionPrograms>();
        plan.moved_mm = std::max(plan.moved_mm, programs.moved_mm());
        for (const auto* program : *programs.regions()) {
            take_region(plan, begin.draw()->surfaces()->size(), gp, *program);
        }
    }
    return plan;
}

std::optional<HeldSums> sums_behind(const FramePlan& plan) {
    if (plan.pass.is_last()) {
        return std::nullopt;
    }
    HeldSums sums{plan.frame, plan.pass, {}};
    for (const FramePlan::Region& region : plan.regions) {
        sums.regions.push_back(region.number);
    }
    return sums;
}

std::string missing_sums(const std::optional<HeldSums>& held, const FramePlan& plan) {
    if (plan.pass.sample == 0) {
        return {};
    }
    const std::string pass =
        fmt::format("sample {} of {}", plan.pass.sample + 1, plan.pass.samples);
    if (!held) {
        return fmt::format("{}: no sums are stored", pass);
    }
    if (held->frame + 1 != plan.frame || held->pass.sample + 1 != plan.pass.sample ||
        held->pass.samples != plan.pass.samples) {
        return fmt::format("{}: the stored sums are those of sample {} of {} of frame {}", pass,
                           held->pass.sample + 1, held->pass.samples, held->frame);
    }
    if (!std::ranges::equal(held->regions, plan.regions, {}, {}, &FramePlan::Region::number)) {
        return fmt::format(
            "{}: the stored sums are those of {} other regions, not of the {} of this frame", pass,
            held->regions.size(), plan.regions.size());
    }
    return {};
}

schema::FaultT lost_frame(std::uint32_t frame, const FrameMessages& messages, std::size_t gps) {
    schema::FaultT fault;
    fault.code = FaultCode::lost_message;
    fault.frame = frame;
    fault.request = static_cast<std::uint16_t>(schema::Body::BeginFrame);
    fault.reason = fmt::format(
        "frame {} is dropped: {}BeginFrame and the programs of {} of {} GPs "
        "arrived",
        frame, messages.begin ? "" : "no ", messages.programs.size(), gps);
    return fault;
}

}  // namespace pxpl5::renderer
