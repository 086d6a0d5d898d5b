// The voxels of a recorded run, or the reason why they are unknown.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "gp_firmware/volume/slice.hpp"
#include "host/inspect/record/recorded_run.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host::inspect {

/// The volume that a frame shows. Slices come from the recorded messages; those that no trace has,
/// from the session's own volume if there is one, or from the phantom that the volume was, if it
/// can be built again.
class KnownVolume {
  public:
    /// held  The volume that the frame shows, if a session still has it; may be null. Outlives it.
    KnownVolume(const RecordedRun& run, std::uint32_t frame, const Volume* held = nullptr);
    explicit KnownVolume(std::optional<RecordedVolume> volume, const Volume* held = nullptr);

    /// Whether the volume's header is recorded: without it there is no shape.
    bool has_shape() const { return volume_.has_value(); }
    const bus::schema::VolumeHeader& header() const;
    const gp::VolumeShape& shape() const { return shape_; }

    /// Sees to it that slices first..last, cut to the volume, can be read.
    /// Returns  Empty, or why they cannot: a sentence that names them.
    std::string need(int first, int last);

    /// Voxel (x, y, z), which is inside and whose slice need() has granted. Throws
    /// std::out_of_range for another voxel.
    double value(int x, int y, int z) const;
    /// nx * ny voxels of slice z, granted by need(). Throws std::out_of_range for another slice.
    std::span<const std::byte> slice(int z) const;
    /// Where the values come from: "recorded slices", "the session's volume" or "phantom:sphere,
    /// built again".
    const std::string& values_from() const { return values_from_; }

    glm::dvec3 to_mm(glm::dvec3 p_voxel) const {
        return glm::dvec3(shape_.voxel_to_patient * glm::dvec4(p_voxel, 1));
    }

  private:
    std::string build_again(const std::string& missing);
    bool fits(const Volume& volume) const;  ///< True if it has as many bytes as the shape needs.
    void take_slices(const Volume& volume);

    std::optional<RecordedVolume> volume_;
    gp::VolumeShape shape_;
    const Volume* held_;
    std::optional<Volume> built_;
    std::string values_from_ = "recorded slices";
};

}  // namespace pxpl5::host::inspect
