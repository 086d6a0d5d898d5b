// Packs a volume into ring messages and assembles it from them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "host/base/digest.hpp"
#include "host/volume/volume.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host {

/// Bytes of one slice of `volume`.
std::size_t slice_bytes(const Volume& volume);

/// VolumeHeader for `volume` with the given id.
bus::Payload volume_header(const Volume& volume, std::uint32_t id);

/// Whole slices that one Slices message holds: a few megabytes, at least one slice.
int slices_per_batch(const Volume& volume);

/// Slices with slices first .. first + count - 1 of the volume.
/// allocator  Memory of the body; null for the heap.
bus::Payload slices_message(const Volume& volume, std::uint32_t id, int first, int count,
                            flatbuffers::Allocator* allocator = nullptr);

/// Puts an incoming volume together. Its digest is made on the way, while more slices come.
class VolumeReceiver {
  public:
    /// Throws RequestError if the header asks for more than the limits.
    void begin(const bus::schema::VolumeHeader& header);
    /// Throws RequestError for slices outside the volume or in the wrong order.
    void add(const bus::schema::Slices& slices);
    /// The volume with the slices so far.
    Volume& volume() { return volume_; }
    /// Slices of the volume that the slices so far stand for.
    int slices_there() const;
    /// The complete volume. Throws RequestError naming how many slices are missing.
    Volume finish();

  private:
    void take_report(const bus::schema::VolumeHeader& header);
    Volume& arriving() { return copy_ ? *copy_ : volume_; }

    Volume volume_;               ///< With the values of the slices so far,
    std::optional<Volume> copy_;  ///< unless the slices are those of a reduced copy.
    Digest digest_;               ///< Digest of these values.
};

}  // namespace pxpl5::host
