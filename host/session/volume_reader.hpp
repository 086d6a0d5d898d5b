// Reads a volume into the host's memory: from a file, through the io process, or a phantom.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/session/io_requests.hpp"
#include "host/volume/volume_messages.hpp"

namespace pxpl5::host {

/// How far loading has come.
struct LoadProgress {
    enum class Phase : std::uint8_t { reading, distributing };
    Phase phase = Phase::distributing;
    int done = 0, total = 0;  ///< Slices read, messages sent; total is 0 while it is unknown.
    friend bool operator==(const LoadProgress&, const LoadProgress&) = default;
};

/// Settings of all loads of a session.
struct LoadSettings {
    /// Called while a volume is loaded; may be empty.
    std::function<void(const LoadProgress&)> progress;
    /// Slabs per slice set; 0: MachinePort::slabs_per_set(), then slabs_per_set_for(). Changes no
    /// surface and no picture.
    int slabs_per_set = 0;
    /// Starts the next io process during a load, because a picture or mesh is written soon after.
    bool will_write = false;
};

/// Processing of a file's voxels; the path is empty.
using ImportOptions = bus::schema::ImportVolumeT;

class VolumeReader {
  public:
    VolumeReader(Conversation& conversation, IoRequests& io, const LoadSettings& settings);

    /// The complete volume. Throws RequestError.
    /// on_slices  Called with the volume so far and its number of slices, if it comes from a file.
    using OnSlices = std::function<void(Volume& volume, int slices)>;
    Volume read(const std::string& source, const ImportOptions& options,
                const OnSlices& on_slices = {});
    /// The complete volumes of a time series from `options.frame` on, as many as `options.volumes`
    /// says or the series has, by one process that reads what they share once. One of a phantom.
    /// Throws RequestError; IoFailure also if only a later volume cannot be read.
    std::vector<Volume> read_several(const std::string& source, const ImportOptions& options,
                                     const OnSlices& on_slices = {});

  private:
    Volume read_phantom(const std::string& source, int frame);
    void begin(const bus::schema::VolumeHeader& header);

    Conversation& conversation_;
    IoRequests& io_;
    const LoadSettings& settings_;
    std::optional<VolumeReceiver> receiver_;
    std::vector<Volume> received_;
    std::size_t wanted_ = 0;  ///< Volumes of the request under way; 0: there is none.
    ImportOptions request_;   ///< The request under way.
};

}  // namespace pxpl5::host
