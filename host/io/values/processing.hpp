// Processing of a volume during its load: crop, smooth, resample, in this order.
#pragma once

#include "host/io/values/import_request.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host::io {

/// Does what `request` asks for, and reports it in findings of kind `processed`.
/// Throws   ImportError naming the wish and the volume's own size.
void process_volume(const ImportRequest& request, Volume& volume);

/// Keeps size[i] voxels from first[i] on. The rest of the patient stays where it is.
void crop(const std::string& file, const std::array<std::uint32_t, 3>& first,
          const std::array<std::uint32_t, 3>& size, Volume& volume);

/// Convolves with a Gaussian along the voxel axes; over uneven slices by their true distances. At
/// the border the weights of the voxels that are there sum to one. NaN and infinities stay, and do
/// not spread.
/// sigma_mm  Standard deviation, above 0. Cut off at 4 of them, where 0.006 % is left.
void smooth(double sigma_mm, Volume& volume);

/// Along an axis: the voxels afterwards and the distance between them, in voxels (slices: in the
/// units of slice_places) before.
struct NewAxis {
    int size = 0;
    double step = 0;
};

/// Trilinear. Voxel 0 stays where it is. slice_places becomes empty; gap_slabs are those that
/// touch a former gap.
void resample(const std::array<NewAxis, 3>& axes, Volume& volume);

}  // namespace pxpl5::host::io
