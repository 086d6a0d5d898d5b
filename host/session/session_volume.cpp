// What a session does with volumes: has the io process read them, and hands them to the GPs.
#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "host/base/digest.hpp"
#include "host/base/error.hpp"
#include "host/base/stopwatch.hpp"
#include "host/phantom/phantom.hpp"
#include "host/session/scene_transfer.hpp"
#include "host/session/session.hpp"

namespace pxpl5::host {

namespace schema = bus::schema;

namespace {

/// Whether the voxels are wanted as they are.
bool is_plain(const ImportOptions& options) {
    return options.series.empty() && options.spacing_mm.empty() && !options.raw &&
           options.crop_first.empty() && options.crop_size.empty() &&
           options.resample_size.empty() && options.resample_spacing_mm.empty() &&
           options.smooth_mm == 0;
}

}  // namespace

void Session::with_io(const std::string& what, ExitCode on_death, bus::Payload request,
                      const std::function<bool()>& done) {
    struct Release {
        MachinePort& machine;
        ~Release() { machine.release_io(); }
    };
    const bus::NodeId io = machine_.start_io(on_death);
    const Release release{machine_};
    io_done_ = false;
    received_.reset();
    receiver_.reset();
    machine_.send(io, std::move(request));
    wait(what, [&] { return done() || fault_.has_value(); });
}

Volume Session::read(const std::string& source, const ImportOptions& options) {
    if (phigs::is_archive(source)) {
        throw RequestError(ExitCode::usage, source + " is a scene, not a volume");
    }
    receive_volume(source, options, [] {});
    return *std::exchange(received_, std::nullopt);
}

/// Leaves the volume in received_.
/// on_slices  Called when some of it is in receiver_.
void Session::receive_volume(const std::string& source, const ImportOptions& options,
                             const std::function<void()>& on_slices) {
    if (is_phantom(source) && is_plain(options)) {
        if (will_write) {
            machine_.prepare_io();
        }
        try {
            received_ = make_phantom(source);
        } catch (const std::invalid_argument& error) {
            throw RequestError(ExitCode::usage, error.what());
        }
        Digest digest;
        digest.add(received_->values);
        received_->digest = digest.value();
        received_->source = source;
        return;
    }
    const std::string told =
        is_phantom(source) ? source : std::filesystem::absolute(source).string();
    ImportOptions request = options;
    request.path = source;
    with_io(source, ExitCode::bad_data, bus::pack(request), [&] {
        if (receiver_ && !received_) {
            receiver_->volume().source = told;
            on_slices();
        }
        return received_.has_value();
    });
    if (will_write) {
        machine_.prepare_io();
    }
    receiver_.reset();
}

void Session::begin_volume_request() {
    memory_bytes_ = 0;
    begin_request([this](const bus::Message& message) {
        const auto* ready = message.as<schema::VolumeReady>();
        if (ready == nullptr || ready->volume() != volume_id_) {
            return false;
        }
        memory_bytes_ += static_cast<std::int64_t>(ready->memory_bytes());
        return true;
    });
}

/// A volume on its way to the GPs, which may still be coming itself.
struct Session::Loading {
    std::string source;
    std::optional<VolumeDistribution> distribution;  ///< None until the volume's shape is known.
    LoadProgress told;
};

LoadReport Session::load(const std::string& source, const ImportOptions& options) {
    if (source.empty()) {
        throw RequestError(ExitCode::usage, "load: the name of the volume is empty");
    }
    if (phigs::is_archive(source)) {
        return load_archive(source);
    }
    struct Cancellable {
        MachinePort& machine;
        explicit Cancellable(MachinePort& port) : machine(port) { machine.allow_cancel(true); }
        ~Cancellable() { machine.allow_cancel(false); }
    };
    const Cancellable cancellable(machine_);
    Loading loading{source, {}, {}};
    try {
        return load_volume(loading, options);
    } catch (const MachineError&) {
        throw;
    } catch (const std::exception&) {
        if (loading.distribution) {
            give_up_volume();
        }
        throw;
    }
}

LoadReport Session::load_volume(Loading& loading, const ImportOptions& options) {
    LoadReport report{loading.source};
    std::int64_t start_ns = now_ns();
    tell({LoadProgress::Phase::reading, 0, 0}, loading);
    receive_volume(loading.source, options, [this, &loading] {
        distribute(receiver_->volume(), receiver_->slices_there(), loading);
    });
    report.read_ms = ms_since(start_ns);

    start_ns = now_ns();
    distribute(*received_, received_->nz, loading);
    volume_ = std::move(received_);
    received_.reset();
    wait(loading.source, [this, &loading] {
        distribute(*volume_, volume_->nz, loading);
        return std::ranges::all_of(machine_.gp_ids(),
                                   [this](bus::NodeId gp) { return answered_.contains(gp); });
    });
    report.distribute_ms = ms_since(start_ns);
    report.memory_bytes = memory_bytes_;
    return report;
}

/// Sends the GPs what can go of a volume of which so many slices are there.
void Session::distribute(Volume& volume, int slices_there, Loading& loading) {
    const std::vector<bus::NodeId>& gps = machine_.gp_ids();
    if (!loading.distribution) {
        if (volume.nz < 2) {
            throw RequestError(
                ExitCode::bad_data,
                fmt::format("{}: {} x {} x {} voxels are a single slice, which has no surface; "
                            "'info' tells of it",
                            loading.source, volume.nx, volume.ny, volume.nz));
        }
        // What was loaded goes only now: until here the new volume might have been unreadable.
        scene.surfaces.clear();
        scene.clips.clear();
        reports_.clear();
        region_costs_.clear();
        archive_.reset();
        volume_.reset();
        ++volume_id_;
        begin_volume_request();
        const int gp_count = static_cast<int>(gps.size());
        volume.slabs_per_set =
            slabs_per_set != 0 ? slabs_per_set : slabs_per_set_for(volume, gp_count);
        const bus::Payload header = volume_header(volume, volume_id_);
        for (const bus::NodeId gp : gps) {
            machine_.send(gp, header);
        }
        loading.distribution.emplace(volume, volume_id_, gp_count);
    }
    VolumeDistribution& distribution = *loading.distribution;
    distribution.send_more(volume, slices_there,
                           {[&](std::size_t gp) { return machine_.takes_more(gps[gp]); },
                            [&](std::size_t gp, bus::Payload payload) {
                                machine_.send(gps[gp], std::move(payload));
                            }});
    tell(slices_there < volume.nz
             ? LoadProgress{LoadProgress::Phase::reading, slices_there, volume.nz}
             : LoadProgress{LoadProgress::Phase::distributing, distribution.sent(),
                            distribution.total()},
         loading);
}

void Session::tell(const LoadProgress& progress_now, Loading& loading) {
    if (progress && progress_now != std::exchange(loading.told, progress_now)) {
        progress(progress_now);
    }
}

/// Leaves nothing of the volume that was on its way, neither on the GPs nor in messages.
void Session::give_up_volume() {
    machine_.allow_cancel(false);  // What follows is short, and half of it would help nobody.
    volume_.reset();
    received_.reset();
    receiver_.reset();
    schema::DropVolumeT drop;
    drop.volume = volume_id_;
    // An empty scene takes the volume's place: when a GP has it, all that the GP had to say of the
    // volume has come.
    ++volume_id_;
    for (const bus::NodeId gp : machine_.gp_ids()) {
        machine_.send(gp, bus::pack(drop));
        machine_.send(gp, phigs::scene_begin(volume_id_, {}));
        machine_.send(gp, phigs::scene_end(volume_id_));
    }
    std::set<bus::NodeId> ready;
    machine_.pump(
        [&](const bus::Message& message) {
            const auto* told = message.as<schema::VolumeReady>();
            if (told != nullptr && told->volume() == volume_id_) {
                ready.insert(message.source());
            }
        },
        [&] { return ready.size() == machine_.gp_ids().size(); });
    fault_.reset();
    drop.volume = volume_id_;
    for (const bus::NodeId gp : machine_.gp_ids()) {
        machine_.send(gp, bus::pack(drop));
    }
}

}  // namespace pxpl5::host
