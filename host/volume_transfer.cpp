#include "host/volume_transfer.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "host/error.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

/// Few and large messages: waking a node costs more than a megabyte of copying.
constexpr std::size_t batch_bytes = std::size_t{8} << 20;
/// What the host takes into its memory.
constexpr std::size_t max_volume_bytes = std::size_t{8} << 30;

static_assert(static_cast<int>(Scalar::float32) == static_cast<int>(schema::ScalarType::float32));
static_assert(static_cast<int>(FindingKind::processed) ==
              static_cast<int>(schema::FindingKind::processed));
static_assert(static_cast<int>(Scalar::uint16) == static_cast<int>(schema::ScalarType::uint16));

std::size_t slice_bytes(const Volume& volume) {
    return static_cast<std::size_t>(volume.nx) * static_cast<std::size_t>(volume.ny) *
           size_bytes(volume.type);
}

}  // namespace

std::vector<int> slices_for_gp(int slice_count, int gp_index, int gp_count) {
    std::vector<int> slices;
    for (int slab = gp_index; slab < slice_count - 1; slab += gp_count) {
        const int first = std::max({slab - 1, 0, slices.empty() ? 0 : slices.back() + 1});
        for (int z = first; z <= std::min(slab + 2, slice_count - 1); ++z) {
            slices.push_back(z);
        }
    }
    return slices;
}

bus::Payload volume_header(const Volume& volume, std::uint32_t id) {
    schema::VolumeHeaderT header;
    header.volume = id;
    header.name = volume.name;
    header.nx = static_cast<std::uint32_t>(volume.nx);
    header.ny = static_cast<std::uint32_t>(volume.ny);
    header.nz = static_cast<std::uint32_t>(volume.nz);
    header.type = static_cast<schema::ScalarType>(volume.type);
    std::array<double, 16> affine{};
    std::memcpy(affine.data(), &volume.voxel_to_patient, sizeof affine);
    header.voxel_to_patient = std::make_unique<schema::Matrix>(flatbuffers::make_span(affine));
    header.minimum = volume.minimum;
    header.maximum = volume.maximum;
    header.slice_places = volume.slice_places;
    header.gap_slabs.assign(volume.gap_slabs.begin(), volume.gap_slabs.end());
    header.modality = volume.modality;
    header.slabs_per_set = static_cast<std::uint16_t>(volume.slabs_per_set);
    for (const Finding& finding : volume.findings) {
        auto wire = std::make_unique<schema::FindingT>();
        wire->kind = static_cast<schema::FindingKind>(finding.kind);
        wire->text = finding.text;
        header.findings.push_back(std::move(wire));
    }
    header.source = volume.source;
    header.digest = volume.digest;
    return bus::pack(header);
}

int slices_per_batch(const Volume& volume) {
    return static_cast<int>(std::max<std::size_t>(1, batch_bytes / slice_bytes(volume)));
}

bus::Payload slices_message(const Volume& volume, std::uint32_t id, int first, int count) {
    const std::size_t size = slice_bytes(volume);
    flatbuffers::FlatBufferBuilder builder(static_cast<std::size_t>(count) * size + 256);
    const auto values =
        builder.CreateVector(reinterpret_cast<const std::uint8_t*>(volume.values.data()) +
                                 static_cast<std::size_t>(first) * size,
                             static_cast<std::size_t>(count) * size);
    return bus::finish(builder, schema::CreateSlices(builder, id, static_cast<std::uint32_t>(first),
                                                     static_cast<std::uint32_t>(count), values));
}

void for_each_slice_batch(const Volume& volume, std::uint32_t id, const std::vector<int>& slices,
                          const std::function<void(bus::Payload)>& send) {
    const int most = slices_per_batch(volume);
    for (std::size_t i = 0; i < slices.size();) {
        int count = 1;
        while (count < most && i + static_cast<std::size_t>(count) < slices.size() &&
               slices[i + static_cast<std::size_t>(count)] == slices[i] + count) {
            ++count;
        }
        send(slices_message(volume, id, slices[i], count));
        i += static_cast<std::size_t>(count);
    }
}

void for_each_slice_batch_of_gp(const Volume& volume, std::uint32_t id, int gp_index, int gp_count,
                                const std::function<void(bus::Payload)>& send) {
    const auto is_own = [&](int z) {
        return std::max(std::min(z, volume.nz - 2), 0) % gp_count == gp_index;
    };
    std::vector<int> alike;
    for (const int z : slices_for_gp(volume.nz, gp_index, gp_count)) {
        if (!alike.empty() && is_own(z) != is_own(alike.back())) {
            for_each_slice_batch(volume, id, std::exchange(alike, {}), send);
        }
        alike.push_back(z);
    }
    for_each_slice_batch(volume, id, alike, send);
}

/// What is not needed to hold the voxels.
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
    volume_.slabs_per_set = header.slabs_per_set();
    if (header.findings() != nullptr) {
        for (const auto* finding : *header.findings()) {
            volume_.findings.push_back(
                {static_cast<FindingKind>(finding->kind()), finding->text()->str()});
        }
    }
}

void VolumeReceiver::begin(const schema::VolumeHeader& header) {
    volume_ = Volume{};
    filled_ = 0;
    digest_ = {};
    volume_.name = header.name()->str();
    volume_.nx = static_cast<int>(header.nx());
    volume_.ny = static_cast<int>(header.ny());
    volume_.nz = static_cast<int>(header.nz());
    volume_.type = static_cast<Scalar>(header.type());
    std::memcpy(&volume_.voxel_to_patient, header.voxel_to_patient()->m()->Data(),
                sizeof volume_.voxel_to_patient);
    volume_.minimum = header.minimum();
    volume_.maximum = header.maximum();
    take_report(header);
    const std::size_t total = slice_bytes(volume_) * header.nz();
    if (total > max_volume_bytes) {
        throw RequestError(
            ExitCode::bad_data,
            fmt::format("{}: {} x {} x {} voxels need {} bytes, the limit is {}", volume_.name,
                        volume_.nx, volume_.ny, volume_.nz, total, max_volume_bytes));
    }
    volume_.values.resize(total);
}

void VolumeReceiver::add(const schema::Slices& slices) {
    const std::size_t size = slice_bytes(volume_), bytes = slices.values()->size();
    if (slices.first_slice() != filled_ || bytes != slices.slice_count() * size ||
        (filled_ + slices.slice_count()) * size > volume_.values.size()) {
        throw RequestError(ExitCode::bad_data,
                           fmt::format("{}: slices {}..{} with {} bytes came where slice {} of {} "
                                       "with {} bytes each was due",
                                       volume_.name, slices.first_slice(),
                                       slices.first_slice() + slices.slice_count(), bytes, filled_,
                                       volume_.nz, size));
    }
    std::memcpy(volume_.values.data() + filled_ * size, slices.values()->data(), bytes);
    digest_.add(std::as_bytes(std::span(slices.values()->data(), bytes)));
    filled_ += slices.slice_count();
}

Volume VolumeReceiver::finish() {
    if (filled_ != static_cast<std::size_t>(volume_.nz)) {
        throw RequestError(ExitCode::bad_data, fmt::format("{}: {} of {} slices arrived",
                                                           volume_.name, filled_, volume_.nz));
    }
    volume_.digest = digest_.value();
    return std::move(volume_);
}

}  // namespace pxpl5::host
