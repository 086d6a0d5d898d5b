// Describes a place in a run: one line per step, and answers to questions.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "host/inspect/map/region_picture.hpp"
#include "host/inspect/step/stepper.hpp"

namespace pxpl5::host::inspect {

/// "#1234  gp-0 surface 0 slab 17+34   TREEgeZERO :16  3 -5 120": the next instruction, or that
/// the region is drawn.
std::string next_line(const Stepper& stepper);

/// The last executed instruction, enabled pixels before and behind it, and what it changed.
/// Executes it once more; at a region's begin, the same as next_line().
std::string done_line(Stepper& stepper);

/// Frame, region, counts, primitive, next instruction and its meaning; several lines.
std::string where_text(const Stepper& stepper);

/// Every field of pixel (x, y) of the picture. Throws RequestError (usage) if it is not in the
/// region.
std::string pixel_text(const Stepper& stepper, int x, int y);

/// The instructions around the next one, `lines` before and behind; marked by =>.
std::string list_text(const Stepper& stepper, int lines);

/// A window of the picture.
struct PictureWindow {
    int x = 0, y = 0, width = 12, height = 8;
};

/// The field's values in the window, as far as it is in the region; enabled pixels have a star.
std::string print_text(const Stepper& stepper, const NamedField& field, PictureWindow window);

/// A window around the enabled pixels, or in the region's middle.
PictureWindow window_of_interest(const Stepper& stepper);

/// "prologue+4", "gp-3 surface 0 slab 17+34", "end+12", or "2+34": word 34 of part 2.
/// Throws RequestError (usage) if the region has no instruction there.
Address address_of(const renderer::RegionPlan& plan, std::string_view text);

}  // namespace pxpl5::host::inspect
