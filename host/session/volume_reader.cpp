#include "host/session/volume_reader.hpp"

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

}  // namespace

VolumeReader::VolumeReader(Conversation& conversation, IoRequests& io, const LoadSettings& settings)
    : conversation_(conversation), io_(io), settings_(settings) {
    conversation_.handle(bus::Body::VolumeHeader, [this](const bus::Message& message) {
        if (!is_reading_ || receiver_) {
            throw RequestError(ExitCode::bad_data,
                               "the io process announced a volume that was not due");
        }
        begin(*message.as<schema::VolumeHeader>());
    });
    conversation_.handle(bus::Body::Slices, [this](const bus::Message& message) {
        if (receiver_ && !received_) {
            receiver_->add(*message.as<schema::Slices>());
        }
    });
    conversation_.handle(bus::Body::VolumeEnd, [this](const bus::Message&) {
        if (receiver_ && !received_) {
            received_ = receiver_->finish();
        }
    });
}

/// The io process decodes the header of a stranger, so that the host checks the files that the io
/// process states before any GP opens them.
void VolumeReader::begin(const schema::VolumeHeader& header) {
    VolumeReceiver receiver;
    receiver.begin(header);
    if (const std::optional<StoredVolume>& stored = receiver.volume().stored) {
        check_slices_files(*stored, request_, conversation_.machine().io_folders());
    }
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
    if (is_phantom(source) && is_plain(options)) {
        return read_phantom(source, std::max(1, static_cast<int>(options.frame)));
    }
    struct Forget {
        VolumeReader& reader;
        ~Forget() {
            reader.receiver_.reset();
            reader.received_.reset();
            reader.is_reading_ = false;
        }
    };
    const Forget forget{*this};
    if (source.empty()) {
        throw RequestError(ExitCode::usage, "the name of the volume is empty");
    }
    is_reading_ = true;
    request_ = options;
    request_.path = source;
    const std::string name =
        is_phantom(source) ? source : std::filesystem::absolute(source).string();
    io_.run(source, ExitCode::bad_data, bus::pack(request_), [&] {
        if (receiver_ && !received_) {
            receiver_->volume().source = name;
            if (on_slices) {
                on_slices(receiver_->volume(), receiver_->slices_there());
            }
        }
        return received_.has_value();
    });
    if (settings_.will_write) {
        conversation_.machine().prepare_io();
    }
    return std::move(*received_);
}

}  // namespace pxpl5::host
