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
constexpr std::size_t batch_bytes = std::size_t{4} << 20;
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

int owner_of(const Volume& volume, int gp_count, int slab) {
    return slab / volume.slabs_per_set % gp_count;
}

}  // namespace

int slabs_per_set_for(const Volume& volume, int gp_count) {
    const std::size_t bytes = slice_bytes(volume) * static_cast<std::size_t>(volume.nz);
    if (bytes <= max_paper_bytes) {
        return 1;
    }
    const int sets = gp_count * sets_per_gp;
    return std::clamp((volume.nz - 1 + sets - 1) / sets, 2, max_slabs_per_set);
}

std::vector<int> slices_for_gp(const Volume& volume, int gp_index, int gp_count) {
    std::vector<int> slices;
    for (int slab = 0; slab < volume.nz - 1; ++slab) {
        if (owner_of(volume, gp_count, slab) == gp_index) {
            const int first = std::max({slab - 1, 0, slices.empty() ? 0 : slices.back() + 1});
            for (int z = first; z <= std::min(slab + 2, volume.nz - 1); ++z) {
                slices.push_back(z);
            }
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

std::vector<SliceBatch> batches_for_gp(const Volume& volume, int gp_index, int gp_count) {
    const auto is_own = [&](int z) {
        return owner_of(volume, gp_count, std::max(std::min(z, volume.nz - 2), 0)) == gp_index;
    };
    const int most = slices_per_batch(volume);
    std::vector<SliceBatch> batches;
    for (const int z : slices_for_gp(volume, gp_index, gp_count)) {
        SliceBatch* last = batches.empty() ? nullptr : &batches.back();
        if (last != nullptr && z == last->end() && last->count < most &&
            is_own(z) == is_own(last->first)) {
            ++last->count;
        } else {
            batches.push_back({z, 1});
        }
    }
    return batches;
}

VolumeDistribution::VolumeDistribution(const Volume& volume, std::uint32_t id, int gp_count)
    : id_(id) {
    for (int gp = 0; gp < gp_count; ++gp) {
        ways_.push_back({batches_for_gp(volume, gp, gp_count), 0});
        total_ += static_cast<int>(ways_.back().batches.size());
    }
}

void VolumeDistribution::send_more(const Volume& volume, int slices_there, const Road& road) {
    for (std::size_t gp = 0; gp < ways_.size(); ++gp) {
        Way& way = ways_[gp];
        while (way.next < way.batches.size() && road.takes_more(gp) &&
               way.batches[way.next].end() <= slices_there) {
            const SliceBatch& batch = way.batches[way.next++];
            road.send(gp, slices_message(volume, id_, batch.first, batch.count));
            ++sent_;
        }
        if (way.next == way.batches.size() && !way.ended) {
            way.ended = true;
            road.send(gp, bus::pack(schema::VolumeEndT{{}, id_}));
        }
    }
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
    volume_.values.reserve(total);  // Pages are taken as slices come.
}

void VolumeReceiver::add(const schema::Slices& slices) {
    const std::size_t size = slice_bytes(volume_), bytes = slices.values()->size();
    const auto filled = static_cast<std::size_t>(slices_there());
    if (slices.first_slice() != filled || bytes != slices.slice_count() * size ||
        filled + slices.slice_count() > static_cast<std::size_t>(volume_.nz)) {
        throw RequestError(ExitCode::bad_data,
                           fmt::format("{}: slices {}..{} with {} bytes came where slice {} of {} "
                                       "with {} bytes each was due",
                                       volume_.name, slices.first_slice(),
                                       slices.first_slice() + slices.slice_count(), bytes, filled,
                                       volume_.nz, size));
    }
    const auto values = std::as_bytes(std::span(slices.values()->data(), bytes));
    volume_.values.insert(volume_.values.end(), values.begin(), values.end());
    digest_.add(values);
}

int VolumeReceiver::slices_there() const {
    return volume_.values.empty() ? 0
                                  : static_cast<int>(volume_.values.size() / slice_bytes(volume_));
}

Volume VolumeReceiver::finish() {
    if (slices_there() != volume_.nz) {
        throw RequestError(
            ExitCode::bad_data,
            fmt::format("{}: {} of {} slices arrived", volume_.name, slices_there(), volume_.nz));
    }
    volume_.digest = digest_.value();
    return std::move(volume_);
}

}  // namespace pxpl5::host
