#include "host/volume/volume_messages.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "host/base/error.hpp"
#include "host/volume/reduced.hpp"
#include "ringbus/stored_volume.hpp"

namespace pxpl5::host {

namespace schema = bus::schema;

namespace {

/// Few and large messages: waking a node costs more than a megabyte of copying.
constexpr std::size_t batch_bytes = std::size_t{4} << 20;

std::unique_ptr<schema::StoredVolumeT> to_wire(const StoredVolume& stored) {
    auto wire = std::make_unique<schema::StoredVolumeT>();
    wire->component = stored.component;
    wire->big_endian = stored.big_endian;
    wire->bits_stored = static_cast<std::uint8_t>(stored.bits_stored);
    for (const SlicesFile& file : stored.files) {
        auto each = std::make_unique<schema::SlicesFileT>();
        each->path = file.path;
        each->offset = file.offset_bytes;
        each->slices = file.slices;
        each->slope = file.scale.slope;
        each->intercept = file.scale.intercept;
        each->size_bytes = file.facts.size_bytes;
        each->inode = file.facts.inode;
        each->modified_ns = file.facts.modified_ns;
        wire->files.push_back(std::move(each));
    }
    return wire;
}

}  // namespace

std::size_t slice_bytes(const Volume& volume) {
    return static_cast<std::size_t>(volume.nx) * static_cast<std::size_t>(volume.ny) *
           size_bytes(volume.type);
}

bus::Payload volume_header(const Volume& volume, std::uint32_t id) {
    schema::VolumeHeaderT header;
    header.volume = id;
    header.name = volume.name;
    header.nx = static_cast<std::uint32_t>(volume.nx);
    header.ny = static_cast<std::uint32_t>(volume.ny);
    header.nz = static_cast<std::uint32_t>(volume.nz);
    header.type = volume.type;
    std::array<double, 16> affine{};
    std::memcpy(affine.data(), &volume.voxel_to_patient, sizeof affine);
    header.voxel_to_patient = std::make_unique<schema::Matrix>(flatbuffers::make_span(affine));
    header.minimum = volume.minimum;
    header.maximum = volume.maximum;
    header.slice_places = volume.slice_places;
    header.gap_slabs.assign(volume.gap_slabs.begin(), volume.gap_slabs.end());
    header.modality = volume.modality;
    header.series = volume.series;
    header.unit = volume.unit;
    header.suv_per_value = volume.suv_per_value;
    header.frame = static_cast<std::uint32_t>(volume.frame);
    header.frames = static_cast<std::uint32_t>(volume.frames);
    header.frame_ms = volume.frame_ms;
    header.times_ms = volume.times_ms;
    for (const NamedWindow& window : volume.windows) {
        auto wire = std::make_unique<schema::NamedWindowT>();
        wire->name = window.name;
        wire->width = window.width;
        wire->level = window.level;
        header.windows.push_back(std::move(wire));
    }
    header.slabs_per_set = static_cast<std::uint16_t>(volume.slabs_per_set);
    for (const Finding& finding : volume.findings) {
        auto wire = std::make_unique<schema::FindingT>();
        wire->kind = finding.kind;
        wire->text = finding.text;
        header.findings.push_back(std::move(wire));
    }
    header.source = volume.source;
    header.digest = volume.digest;
    if (volume.stored) {
        header.stored = to_wire(*volume.stored);
    }
    header.reduction = static_cast<std::uint16_t>(volume.reduction);
    header.gradient = volume.gradient;
    return bus::pack(header);
}

int slices_per_batch(const Volume& volume) {
    return static_cast<int>(std::max<std::size_t>(1, batch_bytes / slice_bytes(volume)));
}

bus::Payload slices_message(const Volume& volume, std::uint32_t id, int first, int count,
                            flatbuffers::Allocator* allocator) {
    const std::size_t size = slice_bytes(volume);
    flatbuffers::FlatBufferBuilder builder(static_cast<std::size_t>(count) * size + 256, allocator);
    const auto values =
        builder.CreateVector(reinterpret_cast<const std::uint8_t*>(volume.values.data()) +
                                 static_cast<std::size_t>(first) * size,
                             static_cast<std::size_t>(count) * size);
    return bus::finish(builder, schema::CreateSlices(builder, id, static_cast<std::uint32_t>(first),
                                                     static_cast<std::uint32_t>(count), values));
}

/// Reads the parts of the header that describe the volume, but not its storage.
void VolumeReceiver::take_report(const schema::VolumeHeader& header) {
    if (header.slice_places() != nullptr) {
        volume_.slice_places.assign(header.slice_places()->begin(), header.slice_places()->end());
    }
    if (header.gap_slabs() != nullptr) {
        volume_.gap_slabs.assign(header.gap_slabs()->begin(), header.gap_slabs()->end());
    }
    if (header.modality() != nullptr) {
        volume_.modality = header.modality()->str();
    }
    volume_.series = header.series() != nullptr ? header.series()->str() : "";
    volume_.unit = header.unit() != nullptr ? header.unit()->str() : "";
    volume_.suv_per_value = header.suv_per_value();
    volume_.frame = static_cast<int>(header.frame());
    volume_.frames = static_cast<int>(header.frames());
    volume_.frame_ms = header.frame_ms();
    if (header.times_ms() != nullptr) {
        volume_.times_ms.assign(header.times_ms()->begin(), header.times_ms()->end());
    }
    if (header.windows() != nullptr) {
        for (const auto* window : *header.windows()) {
            volume_.windows.push_back({window->name()->str(), window->width(), window->level()});
        }
    }
    volume_.slabs_per_set = header.slabs_per_set();
    if (header.findings() != nullptr) {
        for (const auto* finding : *header.findings()) {
            volume_.findings.push_back({finding->kind(), finding->text()->str()});
        }
    }
}

void VolumeReceiver::begin(const schema::VolumeHeader& header) {
    volume_ = Volume{};
    copy_.reset();
    digest_ = {};
    volume_.name = header.name()->str();
    volume_.nx = static_cast<int>(header.nx());
    volume_.ny = static_cast<int>(header.ny());
    volume_.nz = static_cast<int>(header.nz());
    volume_.type = header.type();
    std::memcpy(&volume_.voxel_to_patient, header.voxel_to_patient()->m()->Data(),
                sizeof volume_.voxel_to_patient);
    volume_.minimum = header.minimum();
    volume_.maximum = header.maximum();
    take_report(header);
    if (header.stored() != nullptr) {
        volume_.stored = bus::stored_volume_of(*header.stored());
        volume_.digest = header.digest();
        volume_.reduction = header.reduction();
        if (volume_.reduction > 1) {
            copy_ = reduced_shape(volume_, volume_.reduction);
        }
    }
    const Volume& coming = copy_ ? *copy_ : volume_;
    const std::size_t total = slice_bytes(coming) * static_cast<std::size_t>(coming.nz);
    if (total > max_volume_bytes) {
        throw RequestError(
            ExitCode::bad_data,
            fmt::format("{}: {} x {} x {} voxels need {} bytes, the limit is {}", volume_.name,
                        volume_.nx, volume_.ny, volume_.nz, total, max_volume_bytes));
    }
    arriving().values.reserve(total);  // Pages are taken as slices come.
}

void VolumeReceiver::add(const schema::Slices& slices) {
    Volume& coming = arriving();
    const std::size_t size = slice_bytes(coming), bytes = slices.values()->size();
    const std::size_t filled = coming.values.size() / size;
    if (slices.first_slice() != filled || bytes != slices.slice_count() * size ||
        filled + slices.slice_count() > static_cast<std::size_t>(coming.nz)) {
        throw RequestError(ExitCode::bad_data,
                           fmt::format("{}: slices {}..{} with {} bytes came where slice {} of {} "
                                       "with {} bytes each was due",
                                       volume_.name, slices.first_slice(),
                                       slices.first_slice() + slices.slice_count(), bytes, filled,
                                       coming.nz, size));
    }
    const auto values = std::as_bytes(std::span(slices.values()->data(), bytes));
    coming.values.insert(coming.values.end(), values.begin(), values.end());
    if (!volume_.stored) {  // The io process has read all values of files, and states the digest.
        digest_.add(values);
        volume_.digest = slices_there() == volume_.nz ? digest_.value() : 0;
    }
}

int VolumeReceiver::slices_there() const {
    const Volume& coming = copy_ ? *copy_ : volume_;
    const auto slices = static_cast<int>(coming.values.size() / slice_bytes(coming));
    return std::min(slices * volume_.reduction, volume_.nz);
}

Volume VolumeReceiver::finish() {
    if (slices_there() != volume_.nz) {
        throw RequestError(
            ExitCode::bad_data,
            fmt::format("{}: {} of {} slices arrived", volume_.name, slices_there(), volume_.nz));
    }
    if (copy_) {
        volume_.reduced = std::make_shared<const Volume>(std::move(*copy_));
    }
    return std::move(volume_);
}

}  // namespace pxpl5::host
