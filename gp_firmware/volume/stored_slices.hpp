// Slices that a GP reads from the volume's files.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "gp_firmware/hal/stored_file.hpp"
#include "gp_firmware/volume/slice.hpp"

namespace pxpl5::gp {

class StoredSlices {
  public:
    /// stored  Its files have shape.nz slices. A file is opened when a slice of it is read.
    StoredSlices(const VolumeShape& shape, const StoredVolume& stored);

    /// Reads slice z. Returns nx * ny voxels of shape.type, valid until the next call.
    /// Throws StoredFileError.
    std::span<const std::byte> read(int z);
    /// Throws StoredFileError if the file of the last slice has changed since it was opened. Others
    /// were checked when the next file was opened.
    void check() const {
        if (opened_) {
            opened_->check();
        }
    }

  private:
    /// The index of the file that has slice z, and the slice's place in that file.
    struct Place {
        std::size_t file = 0;
        std::uint32_t slice = 0;
    };
    Place place_of(int z) const;
    const SlicesFile& open(std::size_t file);

    StoredVolume stored_;
    Scalar type_;
    std::vector<std::uint32_t> firsts_;  ///< The first slice of each file.
    std::optional<StoredFile> opened_;   ///< One at a time: a series has thousands of files.
    std::size_t open_ = 0;
    std::vector<std::byte> values_, voxels_;
};

}  // namespace pxpl5::gp
