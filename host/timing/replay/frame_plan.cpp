#include "host/timing/replay/frame_plan.hpp"

#include <algorithm>
#include <cassert>
#include <functional>
#include <numeric>

#include "generated/vocabulary.hpp"
#include "host/timing/counts/check_work.hpp"
#include "host/timing/replay/deal.hpp"

namespace pxpl5::host::timing {

namespace {

/// Cycles of a region that are not a bin's.
struct OwnCycles {
    std::uint64_t prologue = 0, end = 0, port = 0;
    std::vector<std::uint64_t> doors;  ///< Same as RegionPlan::doors.
};

std::uint32_t door_of(RegionPlan& region, OwnCycles& own, std::uint32_t surface) {
    const auto found = std::ranges::find(region.doors, surface, &Door::surface);
    const auto index = static_cast<std::uint32_t>(found - region.doors.begin());
    if (found == region.doors.end()) {
        region.doors.push_back({surface, 0});
        own.doors.push_back(0);
    }
    return index;
}

void add_own(RegionPlan& region, OwnCycles& own, const PartWork& part) {
    const std::uint64_t array = part.cycles() - std::min(part.port_cycles, part.cycles());
    own.port += part.port_cycles;
    switch (part.kind) {
        case PartKind::prologue:
            own.prologue += array;
            break;
        case PartKind::shut_door:
        case PartKind::open_door:
            own.doors[door_of(region, own, part.surface)] += array;
            break;
        case PartKind::depths:
        case PartKind::end_of_region:
            own.end += array;
            break;
        case PartKind::segment:
            break;
    }
}

/// Fills the bins of all regions.
class Binner {
  public:
    Binner(const Machine& machine, std::vector<RegionPlan>& regions, std::vector<Bin>& bins,
           std::vector<std::vector<DoorPlace>>& door_places, std::vector<OwnCycles>& own)
        : machine_(machine),
          regions_(regions),
          bins_(bins),
          door_places_(door_places),
          own_(own),
          deal_(machine.gps) {}

    void add(const PartWork& part) {
        const Hand whole{part.slab % machine_.gps, part.primitives, part.words, part.cycles()};
        if (machine_.share == Sharing::own) {
            give(part, whole);
        } else {
            deal_(whole, [&](const Hand& hand) { give(part, hand); });
        }
    }

  private:
    void give(const PartWork& part, const Hand& hand) {
        if (hand.words == 0) {
            own_[part.region].end += hand.cycles;  // Nothing that it could travel with.
            return;
        }
        const std::size_t at = part.region * std::size_t{machine_.gps} + hand.gp;
        if (!regions_[part.region].doors.empty()) {
            note_door(part, at);
        }
        bins_[at].words += hand.words;
        bins_[at].cycles += hand.cycles;
    }

    void note_door(const PartWork& part, std::size_t at) {
        const std::vector<Door>& doors = regions_[part.region].doors;
        const auto found = std::ranges::find(doors, part.surface, &Door::surface);
        if (found == doors.end()) {
            return;
        }
        door_places_.resize(bins_.size());
        const auto door = static_cast<std::uint32_t>(found - doors.begin());
        if (std::ranges::find(door_places_[at], door, &DoorPlace::door) == door_places_[at].end()) {
            door_places_[at].push_back({door, bins_[at].words});
        }
    }

    const Machine& machine_;
    std::vector<RegionPlan>& regions_;
    std::vector<Bin>& bins_;
    std::vector<std::vector<DoorPlace>>& door_places_;
    std::vector<OwnCycles>& own_;
    Deal deal_;
};

}  // namespace

FramePlan::FramePlan(const Machine& machine, const Costs& costs, const FrameWork& frame)
    : gps_(machine.gps), reads_out_(frame.reads_out) {
    check_frame(frame);
    regions_.resize(frame.regions());
    bins_.resize(regions_.size() * gps_);
    const std::size_t of_view = regions_.size() / frame.views;
    for (std::size_t i = 0; i < regions_.size(); ++i) {
        regions_[i].view = static_cast<std::uint32_t>(i / of_view);
        regions_[i].pixel_words = reads_out_ ? region_pixels : 1;
    }
    add_parts(machine, costs, frame);
    add_draw_times(machine, costs, frame);
}

std::span<const DoorPlace> FramePlan::doors_of(std::size_t region, std::size_t gp) const {
    if (door_places_.empty()) {
        return {};
    }
    return door_places_[region * gps_ + gp];
}

void FramePlan::add_parts(const Machine& machine, const Costs& costs, const FrameWork& frame) {
    std::vector<OwnCycles> own(regions_.size());
    Binner binner(machine, regions_, bins_, door_places_, own);
    for (const PartWork& part : frame.parts) {
        RegionPlan& region = regions_[part.region];
        if (part.kind == PartKind::segment) {
            binner.add(part);
            continue;
        }
        add_own(region, own[part.region], part);
        if (part.kind == PartKind::depths && reads_out_) {
            region.pixel_words = std::uint64_t{2} * region_pixels;
        }
    }
    for (std::size_t i = 0; i < regions_.size(); ++i) {
        regions_[i].prologue = costs.renderer(own[i].prologue);
        regions_[i].end = costs.renderer(own[i].end);
        regions_[i].port = costs.renderer(own[i].port);
        for (std::size_t door = 0; door < own[i].doors.size(); ++door) {
            regions_[i].doors[door].time = costs.renderer(own[i].doors[door]);
        }
    }
}

void FramePlan::add_draw_times(const Machine& machine, const Costs& costs, const FrameWork& frame) {
    std::vector<std::uint64_t> primitives(gps_), words(gps_);
    Deal deal(gps_);
    for (const DrawnSlab& slab : frame.drawn) {
        if (machine.share == Sharing::own) {
            primitives[slab.slab % gps_] += slab.primitives;
        } else {
            deal({0, slab.primitives, 0, 0},
                 [&](const Hand& hand) { primitives[hand.gp] += hand.primitives; });
        }
    }
    for (std::size_t at = 0; at < bins_.size(); ++at) {
        words[at % gps_] += bins_[at].words;
    }
    draw_times_.resize(gps_);
    for (std::size_t gp = 0; gp < gps_; ++gp) {
        draw_times_[gp] =
            costs.gp(static_cast<double>(primitives[gp]) * machine.gp_draw_primitive_cycles +
                     static_cast<double>(words[gp]) * machine.gp_emit_word_cycles);
    }
}

namespace {

std::vector<std::uint16_t> round_robin(std::size_t regions, std::size_t renderers) {
    std::vector<std::uint16_t> assignment(regions);
    for (std::size_t region = 0; region < regions; ++region) {
        assignment[region] = static_cast<std::uint16_t>(region % renderers);
    }
    return assignment;
}

}  // namespace

bool is_handed_out(Assignment assignment) {
    return assignment == Assignment::first_free || assignment == Assignment::longest_first;
}

std::vector<std::uint16_t> static_assignment(const Machine& machine, const FrameWork& frame) {
    assert(!is_handed_out(machine.assignment));
    if (machine.assignment == Assignment::recorded) {
        check_assignment(frame, machine.renderers);
        return frame.assignment;
    }
    return round_robin(frame.regions(), machine.renderers);
}

// longest_first: list scheduling, longest processing time first (Graham 1969).
std::vector<std::uint32_t> order_of(Assignment assignment, std::size_t regions,
                                    std::span<const std::uint64_t> costs) {
    std::vector<std::uint32_t> order(regions);
    std::iota(order.begin(), order.end(), 0U);
    if (assignment == Assignment::longest_first && costs.size() == regions) {
        std::ranges::stable_sort(order, std::greater{}, [&](std::size_t i) { return costs[i]; });
    }
    return order;
}

}  // namespace pxpl5::host::timing
