// One Renderer's part of a frame, put together from the messages that it received.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "renderer_firmware/igc/region.hpp"
#include "renderer_firmware/igc/region_program.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::renderer {

/// No GP has this index.
inline constexpr std::uint32_t no_gp = 0xFFFF'FFFF;

/// What has come for one frame.
struct FrameMessages {
    std::optional<bus::Message> begin;               ///< BeginFrame.
    std::map<std::uint32_t, bus::Message> programs;  ///< RegionPrograms by GP.
};

/// Something in what a GP has sent for a frame.
struct FrameFault {
    bus::schema::FaultCode code{};
    std::uint32_t gp = no_gp;
    std::string reason;
};

/// What one Renderer does for a frame. Segments point into the messages, which outlive the plan.
struct FramePlan {
    struct Region {
        std::uint32_t number = 0;
        std::vector<Segment> segments;  ///< Of all GPs, as they came.
    };
    std::uint32_t frame = 0;
    bool counts = false;  ///< The host wants each part's.
    Pass pass;
    RegionPrograms programs;
    std::vector<Region> regions;  ///< This Renderer's own, ascending.
    std::vector<FrameFault> faults;
};

/// How the frame is lit.
Shading shading_of(const bus::schema::DrawFrame& draw);

/// "GP 3, region 5, surface 0, slab 17", for texts.
std::string place_of(std::uint32_t gp, std::uint32_t region, std::uint32_t surface,
                     std::uint32_t slab);

/// A plan's programs as a region runs them; they point into `programs`. A pass's end of a region is
/// that of slot 0.
/// Throws std::logic_error if one of them is none (a bug of ours).
RegionFrame region_frame(const RegionPrograms& programs);

/// messages  Hold `begin`; programs of other regions than the Renderer's are a fault.
/// renderer  Index of the Renderer.
FramePlan plan_frame(const FrameMessages& messages, std::uint32_t renderer);

/// Of the passes of a picture that were drawn: what the backing store holds.
struct HeldSums {
    std::uint32_t frame = 0;  ///< Of the newest.
    Pass pass;
    std::vector<std::uint32_t> regions;  ///< By slot.
};

/// What the backing store holds behind the frame; nothing but behind a pass.
std::optional<HeldSums> sums_behind(const FramePlan& plan);

/// Why a pass cannot add to what is held; empty if it can, or is a picture's first.
std::string missing_sums(const std::optional<HeldSums>& held, const FramePlan& plan);

}  // namespace pxpl5::renderer
