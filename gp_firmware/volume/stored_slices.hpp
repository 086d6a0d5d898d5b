// Slices that a GP reads from the volume's file.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "gp_firmware/hal/stored_file.hpp"
#include "gp_firmware/volume/slice.hpp"

namespace pxpl5::gp {

class StoredSlices {
  public:
    /// Opens the file. Throws StoredFileError.
    StoredSlices(const VolumeShape& shape, const SlicesFile& file);

    /// Reads slice z. Returns nx * ny voxels of shape.type, valid until the next call.
    /// Throws StoredFileError.
    std::span<const std::byte> read(int z);
    /// Throws StoredFileError if the file has changed since it was opened.
    void check() const { opened_.check(); }

  private:
    SlicesFile file_;
    Scalar type_;
    StoredFile opened_;
    std::vector<std::byte> stored_, voxels_;
};

}  // namespace pxpl5::gp
