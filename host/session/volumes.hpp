// The volume or the scene of an archive that the GPs hold, and how it gets there.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"
#include "host/session/transfer/scene_transfer.hpp"
#include "host/session/transfer/volume_transfer.hpp"
#include "host/session/volume_reader.hpp"

namespace pxpl5::host {

struct LoadReport {
    std::string source;
    double read_ms = 0;        ///< Until the volume is decoded or built.
    double distribute_ms = 0;  ///< From then on until the last GP has its slice sets.
    std::int64_t memory_bytes = 0;
};

class Volumes {
  public:
    /// on_replaced  Called when the content of the GPs goes, before the next content is sent.
    Volumes(Conversation& conversation, IoRequests& io, Scene& scene, const LoadSettings& settings,
            std::function<void()> on_replaced);

    /// Reads a file or folder, or builds "phantom:NAME", and distributes the volume while it is
    /// read. Removes all surfaces. A volume that cannot be read leaves the previous volume loaded.
    /// If a GP cannot hold its share, or on Ctrl-C (an exception of its own), nothing is loaded.
    /// A PPHIGS archive is a scene instead of a volume.
    LoadReport load(const std::string& source, const ImportOptions& options = {});
    /// Gives the content to the GPs of a machine that has been started again, and removes all
    /// surfaces. An archive is read again. If this fails, the host keeps the content, and the
    /// machine must be started again, or drop() must follow.
    void give_again();
    /// Gives the GPs another volume of the same series, and removes all surfaces and clip planes.
    /// Returns the former volume. If the machine ends meanwhile (MachineError), the host still has
    /// the former volume. If a GP cannot hold the new one (RequestError), nothing is loaded.
    Volume exchange(Volume next);
    /// Removes the content.
    void drop();
    /// Reads a volume without distributing it.
    Volume read(const std::string& source, const ImportOptions& options = {});
    /// Reads volumes of the loaded series without distributing them, as
    /// VolumeReader::read_several(). A viewer's `cancel` ends only this.
    std::vector<Volume> read_of_series(int frame, int count);
    /// Starts the process of the next read, which then begins at once.
    void prepare_read() { conversation_.machine().prepare_io(); }
    /// Reads an archive without distributing it.
    ArchiveFacts read_archive(const std::string& source);

    bool has_volume() const { return volume_.has_value(); }
    /// Throws RequestError if no volume is loaded.
    const Volume& volume() const;
    /// The archive that is loaded, without its parts; null if none is.
    const ArchiveFacts* archive() const { return archive_ ? &archive_->facts : nullptr; }
    /// The surfaces of the archive, one per material.
    const std::vector<Surface>& archive_surfaces() const { return archive_.value().surfaces; }

    /// How the volume was read from its source.
    const ImportOptions& options() const { return options_; }
    int loads() const { return loads_; }  ///< Volumes that were loaded so far.
    /// Number of the volume or scene that the GPs hold.
    std::uint32_t id() const { return id_; }
    /// An id that no surface of the scene has. Ids are used in turn, so that late messages about
    /// the surface that had an id before have long arrived.
    std::uint16_t new_surface_id();

  private:
    struct HeldArchive {
        ArchiveFacts facts;
        std::vector<Surface> surfaces;
    };

    /// While it exists, Ctrl-C ends only the load.
    class Cancellable {
      public:
        explicit Cancellable(MachinePort& machine) : machine_(machine) {
            machine_.allow_cancel(true);
        }
        ~Cancellable() { machine_.allow_cancel(false); }
        Cancellable(const Cancellable&) = delete;
        Cancellable& operator=(const Cancellable&) = delete;

      private:
        MachinePort& machine_;
    };

    struct Loading;
    bus::Message read_content(const std::string& source);
    LoadReport load_archive(const std::string& source);
    LoadReport distribute_archive(const std::string& source, const bus::Message& message);
    LoadReport load_volume(Loading& loading, const ImportOptions& options);
    void send(Volume& volume, Loading& loading);
    void begin_distribution(Volume& volume, Loading& loading);
    void distribute(Volume& volume, int slices_there, Loading& loading);
    void replace_content();
    void report_progress(const LoadProgress& now, Loading& loading) const;
    void discard_volume();
    void discard_canceled();

    Conversation& conversation_;
    Scene& scene_;
    const LoadSettings& settings_;
    std::function<void()> on_replaced_;
    IoRequests& io_;
    VolumeReader reader_;
    std::optional<Volume> volume_;
    ImportOptions options_;
    int loads_ = 0;
    std::optional<HeldArchive> archive_;  ///< Never together with a volume.
    std::uint32_t id_ = 0;
    std::uint16_t next_surface_id_ = 0;
    std::int64_t memory_bytes_ = 0;  ///< In use over all GPs after the load.
};

}  // namespace pxpl5::host
