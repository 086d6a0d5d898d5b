#include "host/inspect/step/scrub.hpp"

#include <algorithm>

#include "host/inspect/listing/enabled_pixels.hpp"
#include "host/inspect/map/region_picture.hpp"
#include "isa/disassemble.hpp"

namespace pxpl5::host::inspect {

namespace {

constexpr std::uint32_t disabled_alpha = 254, alpha_shift = 24;

/// True in and after the end-of-region program, which computes the colors.
bool has_colors(const RegionWalk& walk) {
    return walk.done() || walk.plan().parts[walk.at().part].kind == PartKind::end_of_region;
}

}  // namespace

RegionScrub::RegionScrub(const RecordedRegion& region) : region_(region), stepper_(region.plan) {
    stepper_.seek_end();
    count_ = stepper_.executed();
}

/// Executes one instruction, and adds the instruction and its effect to the view.
void RegionScrub::take_line(RegionPixel pixel, ScrubView& view) {
    const RegionWalk& walk = stepper_.walk();
    const isa::Instruction next = walk.next();
    ScrubLine& line = view.lines.emplace_back();
    line.at = stepper_.executed();
    line.address = to_text(walk.plan(), walk.at());
    line.text = isa::disassemble(next, walk.coefficients());
    line.meaning = isa::info(next.op).doc;
    const InstructionValues values(next, walk.coefficients(), pixel, stepper_.executor());
    stepper_.step();
    line.effect = values.text(stepper_.executor());
}

void RegionScrub::take_picture(const ScrubWish& wish, ScrubView& view) const {
    view.field = !wish.field.empty() ? wish.field : has_colors(stepper_.walk()) ? "rgb" : "normal";
    const renderer::fast::Fast& executor = stepper_.executor();
    view.rgba = picture_of(executor, field_of(view.field));
    view.enabled = enabled_count(executor.pixels());
    for (int i = 0; i < region_px * region_px; ++i) {
        if (!executor.enabled(i % region_px, i / region_px)) {
            std::uint32_t& word = view.rgba[static_cast<std::size_t>(i)];
            word = (word & ((1U << alpha_shift) - 1)) | disabled_alpha << alpha_shift;
        }
    }
}

ScrubView RegionScrub::view(const ScrubWish& wish, RegionPixel pixel) {
    ScrubView view;
    view.count = count_;
    view.at = wish.at < 0 ? count_ : std::min(static_cast<std::uint64_t>(wish.at), count_);
    view.region = region_.place.number;
    view.renderer = region_.renderer;
    view.x0_px = region_.place.x0_px;
    view.y0_px = region_.place.y0_px;
    stepper_.seek(view.at - std::min(view.at, scrub_lines_before));
    while (stepper_.executed() < view.at) {
        take_line(pixel, view);
    }
    take_picture(wish, view);
    while (!stepper_.done() && stepper_.executed() < view.at + scrub_lines_behind) {
        take_line(pixel, view);
    }
    return view;
}

}  // namespace pxpl5::host::inspect
