// Distributes a frame's work over the GPs and Renderers of a machine.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/timing/counts/work.hpp"
#include "host/timing/replay/costs.hpp"

namespace pxpl5::host::timing {

/// The words that one GP sends for one region.
struct Bin {
    std::uint64_t words = 0;
    std::uint64_t cycles = 0;  ///< The Renderer's.
};

/// A surface's parts of the Renderer that run with its first packet in a region.
struct Door {
    std::uint32_t surface = 0;
    Ns time = 0;
};

/// Where a surface with a door begins in a bin.
struct DoorPlace {
    std::uint32_t door = 0;  ///< Index in the region's.
    std::uint64_t word = 0;
};

struct RegionPlan {
    Ns prologue = 0;
    Ns end = 0;   ///< The array's part of depths and end of region.
    Ns port = 0;  ///< Pixels leave the array.
    std::uint64_t pixel_words = 0;
    std::uint32_t view = 0;
    std::vector<Door> doors;
};

/// Does not change while the frame is drawn, however often.
class FramePlan {
  public:
    /// Throws RequestError (bad_data) that names what a frame's counts have and may not.
    FramePlan(const Machine& machine, const Costs& costs, const FrameWork& frame);

    std::size_t regions() const { return regions_.size(); }
    std::size_t views() const { return regions_.empty() ? 0 : regions_.back().view + 1; }
    const RegionPlan& region(std::size_t index) const { return regions_[index]; }
    const Bin& bin(std::size_t region, std::size_t gp) const { return bins_[region * gps_ + gp]; }
    /// Doors that begin in a bin, by their words.
    std::span<const DoorPlace> doors_of(std::size_t region, std::size_t gp) const;
    Ns draw_time(std::size_t gp) const { return draw_times_[gp]; }
    bool reads_out() const { return reads_out_; }

  private:
    void add_parts(const Machine& machine, const Costs& costs, const FrameWork& frame);
    void add_draw_times(const Machine& machine, const Costs& costs, const FrameWork& frame);

    std::size_t gps_;
    bool reads_out_;
    std::vector<RegionPlan> regions_;
    std::vector<Bin> bins_;
    std::vector<std::vector<DoorPlace>> door_places_;  ///< Like bins_; empty without doors.
    std::vector<Ns> draw_times_;
};

/// Whether the Master hands regions out while Renderers draw; else they have them from the start.
bool is_handed_out(Assignment assignment);

/// The Renderer of each region. For assignments that are not handed out.
std::vector<std::uint16_t> static_assignment(const Machine& machine, const FrameWork& frame);

/// The order in which regions are handed out. `costs`: cycles of each region of the newest frame
/// that is drawn; empty if there is none.
std::vector<std::uint32_t> order_of(Assignment assignment, std::size_t regions,
                                    std::span<const std::uint64_t> costs);

}  // namespace pxpl5::host::timing
