// One Renderer's part of a frame, assembled from the received messages.
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
#include "ringbus/rules/pass.hpp"

namespace pxpl5::renderer {

/// The index of no GP.
inline constexpr std::uint32_t no_gp = 0xFFFF'FFFF;

/// The messages that have arrived for one frame.
struct FrameMessages {
    std::optional<bus::Message> begin;               ///< BeginFrame.
    std::map<std::uint32_t, bus::Message> programs;  ///< RegionPrograms by GP.
};

/// An error in the messages of a GP for a frame.
struct FrameFault {
    bus::schema::FaultCode code{};
    std::uint32_t gp = no_gp;
    std::string reason;
};

/// One Renderer's work for a frame. Segments point into the messages, which must outlive the plan.
struct FramePlan {
    struct Region {
        std::uint32_t number = 0;
        std::vector<Segment> segments;  ///< Segments of all GPs, in order of arrival.
    };
    std::uint32_t frame = 0;
    bool counts = false;  ///< The host has requested counts of each part.
    double moved_mm = 0;  ///< The largest of the messages.
    Pass pass;
    RegionPrograms programs;
    std::vector<Region> regions;  ///< The regions of this Renderer, ascending.
    std::vector<FrameFault> faults;
};

/// Returns the lighting of the frame.
Shading shading_of(const bus::schema::DrawFrame& draw);

/// Returns a place for messages, such as "GP 3, region 5, surface 0, slab 17".
std::string place_of(std::uint32_t gp, std::uint32_t region, std::uint32_t surface,
                     std::uint32_t slab);

/// Returns the programs of a plan in the form for draw_region(). They point into `programs`. The
/// end-of-region program of a pass is the one of slot 0.
/// Throws std::logic_error if a program is invalid (a bug of ours).
RegionFrame region_frame(const RegionPrograms& programs);

/// messages  Contain `begin`. Programs for regions of other Renderers are a fault.
/// renderer  Index of the Renderer.
FramePlan plan_frame(const FrameMessages& messages, std::uint32_t renderer);

/// The sums in the backing store, after some passes of a picture.
struct HeldSums {
    std::uint32_t frame = 0;  ///< Frame of the newest pass.
    Pass pass;
    std::vector<std::uint32_t> regions;  ///< Regions by slot.
};

/// Returns the contents of the backing store after the frame; nullopt after a frame that is not a
/// pass.
std::optional<HeldSums> sums_behind(const FramePlan& plan);

/// Returns why a pass cannot add to the stored sums. Empty if the pass can, or is the first one.
std::string missing_sums(const std::optional<HeldSums>& held, const FramePlan& plan);

/// The fault of a frame that can no longer become complete: `gps` GPs should have sent programs.
bus::schema::FaultT lost_frame(std::uint32_t frame, const FrameMessages& messages, std::size_t gps);

}  // namespace pxpl5::renderer
