#include "host/session/volume_reader.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "host/base/digest.hpp"
#include "host/base/error.hpp"
#include "host/phantom/phantom.hpp"
#include "host/session/transfer/slices_file_check.hpp"

namespace pxpl5::host {

namespace schema = bus::schema;

namespace {

/// True if the voxels are not processed; they may be those of any volume of a time series.
bool is_plain(const ImportOptions& options) {
    return options.series.empty() && options.spacing_mm.empty() && !options.raw &&
           options.orientation.empty() && options.origin_mm.empty() && options.crop_first.empty() &&
           options.crop_size.empty() && options.resample_size.empty() &&
           options.resample_spacing_mm.empty() && options.smooth_mm == 0 &&
           options.read != ReadBy::gps;
}

/// Throws RequestError (bad_data) unless `next` follows the volumes of its series.
void check_next(const Volume& next, const std::vector<Volume>& before) {
    const Volume& last = before.back();
    std::uint64_t bytes = slice_bytes(next) * static_cast<std::size_t>(next.nz);
    for (const Volume& volume : before) {
        bytes += volume.values.size();
    }
    if (next.frame != last.frame + 1 || next.frames != last.frames || next.nx != last.nx ||
        next.ny != last.ny || next.nz != last.nz || bytes > max_volume_bytes) {
        throw IoFailure(
            ExitCode::bad_data,
            fmt::format("{}: volume {} of {} with {} x {} x {} voxels follows volume {} of {} with "
                        "{} x {} x {}. The {} volumes have {} bytes, at most {} are possible",
                        last.source, next.frame, next.frames, next.nx, next.ny, next.nz, last.frame,
                        last.frames, last.nx, last.ny, last.nz, before.size() + 1, bytes,
                        max_volume_bytes));
    }
}

}  // namespace

VolumeReader::VolumeReader(Conversation& conversation, IoRequests& io, const LoadSettings& settings)
    : conversation_(conversation), io_(io), settings_(settings) {
    conversation_.handle(bus::Body::VolumeHeader, [this](const bus::Message& message) {
        if (receiver_ || received_.size() >= wanted_) {
            throw RequestError(ExitCode::bad_data,
                               "the io process announced a volume that was not due");
        }
        begin(*message.as<schema::VolumeHeader>());
    });
    conversation_.handle(bus::Body::Slices, [this](const bus::Message& message) {
        if (receiver_) {
            receiver_->add(*message.as<schema::Slices>());
        }
    });
    conversation_.handle(bus::Body::VolumeEnd, [this](const bus::Message&) {
        if (receiver_) {
            received_.push_back(receiver_->finish());
            receiver_.reset();
        }
    });
}

/// The io process decodes the header of a stranger, so that the host checks the files that the io
/// process states before any GP opens them, and that all volumes together are no larger than one
/// may be.
void VolumeReader::begin(const schema::VolumeHeader& header) {
    VolumeReceiver receiver;
    receiver.begin(header);
    Volume& volume = receiver.volume();
    if (const std::optional<StoredVolume>& stored = volume.stored) {
        check_slices_files(*stored, request_, conversation_.machine().io_folders());
    }
    if (!received_.empty()) {
        check_next(volume, received_);
    }
    volume.gradient = request_.gradient;
    volume.source = is_phantom(request_.path) ? request_.path
                                              : std::filesystem::absolute(request_.path).string();
    wanted_ = std::min(
        wanted_, received_.size() + static_cast<std::size_t>(1 + volume.frames - volume.frame));
    receiver_ = std::move(receiver);
}

Volume VolumeReader::read_phantom(const std::string& source, int frame) {
    if (settings_.will_write) {
        conversation_.machine().prepare_io();
    }
    try {
        Volume volume = make_phantom(source, frame);
        Digest digest;
        digest.add(volume.values);
        volume.digest = digest.value();
        volume.source = source;
        return volume;
    } catch (const std::invalid_argument& error) {
        throw RequestError(ExitCode::usage, error.what());
    }
}

Volume VolumeReader::read(const std::string& source, const ImportOptions& options,
                          const OnSlices& on_slices) {
    ImportOptions one = options;
    one.volumes = 1;
    return std::move(read_several(source, one, on_slices).front());
}

std::vector<Volume> VolumeReader::read_several(const std::string& source,
                                               const ImportOptions& options,
                                               const OnSlices& on_slices) {
    if (is_phantom(source) && is_plain(options)) {
        std::vector<Volume> volumes;
        volumes.push_back(read_phantom(source, std::max(1, static_cast<int>(options.frame))));
        volumes.back().gradient = options.gradient;
        return volumes;
    }
    struct Forget {
        VolumeReader& reader;
        ~Forget() {
            reader.receiver_.reset();
            reader.received_.clear();
            reader.wanted_ = 0;
        }
    };
    const Forget forget{*this};
    if (source.empty()) {
        throw RequestError(ExitCode::usage, "the name of the volume is empty");
    }
    request_ = options;
    request_.path = source;
    wanted_ = options.volumes;
    io_.run(source, ExitCode::bad_data, bus::pack(request_), [&] {
        if (receiver_ && on_slices) {
            on_slices(receiver_->volume(), receiver_->slices_there());
        }
        return received_.size() == wanted_;
    });
    if (settings_.will_write) {
        conversation_.machine().prepare_io();
    }
    return std::move(received_);
}

}  // namespace pxpl5::host
