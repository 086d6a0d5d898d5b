// Windows of gray values for pictures of slices.
#pragma once

#include <optional>

#include "host/surface/atlas/histogram.hpp"

namespace pxpl5::host {

/// The window that the file or the kind of scan gives: standardized uptake values from 0 to 10,
/// else the file's preferred window, else soft tissue for values that are Hounsfield units, as the
/// file states or air and bone suggest. Nothing for other scans. The viewer's `firstWindow` has the
/// same rules.
std::optional<GrayWindow> stated_window(const Volume& volume);

/// stated_window(), else a window without the darkest and the brightest 2 % of the voxels. The
/// lowest bin does not count if it has more than half of them, as the air around a patient does.
///
/// counted  histogram(volume, window_bins)
GrayWindow usual_window(const Volume& volume, const Histogram& counted);

}  // namespace pxpl5::host
