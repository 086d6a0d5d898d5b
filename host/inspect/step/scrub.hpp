// Steps through a region and shows it: what a scrubber in a viewer asks for.
#pragma once

#include <cstdint>

#include "host/inspect/listing/instruction_values.hpp"
#include "host/inspect/step/region_stepper.hpp"
#include "host/inspect/step/scrub_view.hpp"

namespace pxpl5::host::inspect {

/// Lines before the next instruction, and from it on.
inline constexpr std::uint64_t scrub_lines_before = 8, scrub_lines_behind = 12;

class RegionScrub {
  public:
    /// region  Outlives it. Is executed once to its end, to count.
    explicit RegionScrub(const RecordedRegion& region);

    std::uint32_t region() const { return region_.place.number; }
    /// pixel  Whose values the lines tell of.
    /// Throws RequestError (usage) for a field that there is not.
    ScrubView view(const ScrubWish& wish, RegionPixel pixel);

  private:
    void take_line(RegionPixel pixel, ScrubView& view);
    void take_picture(const ScrubWish& wish, ScrubView& view) const;

    const RecordedRegion& region_;
    RegionStepper stepper_;
    std::uint64_t count_ = 0;
};

}  // namespace pxpl5::host::inspect
