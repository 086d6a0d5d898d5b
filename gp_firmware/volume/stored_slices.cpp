#include "gp_firmware/volume/stored_slices.hpp"

#include <string>

namespace pxpl5::gp {

StoredSlices::StoredSlices(const VolumeShape& shape, const SlicesFile& file)
    : file_(file),
      type_(shape.type),
      opened_(file.path, file.facts),
      stored_(shape.slice_voxels() * component_bytes(file.stored)),
      voxels_(shape.slice_voxels() * size_bytes(shape.type)) {}

std::span<const std::byte> StoredSlices::read(int z) {
    opened_.read(file_.offset_bytes + static_cast<std::uint64_t>(z) * stored_.size(), stored_);
    if (!convert_stored(stored_, file_, type_, voxels_)) {
        throw StoredFileError(file_.path + ": slice " + std::to_string(z) +
                              " has a value that does not fit into " + enum_name(type_) +
                              ", so that the file has changed. Load it again");
    }
    return voxels_;
}

}  // namespace pxpl5::gp
