#include "host/inspect/record/known_volume.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "gp_firmware/node/messages.hpp"
#include "host/base/digest.hpp"
#include "host/phantom/phantom.hpp"

namespace pxpl5::host::inspect {

KnownVolume::KnownVolume(const RecordedRun& run, std::uint32_t frame, const Volume* held)
    : KnownVolume(run.volume(frame), held) {}

KnownVolume::KnownVolume(std::optional<RecordedVolume> volume, const Volume* held)
    : volume_(std::move(volume)), held_(held) {
    if (volume_) {
        shape_ = gp::shape_of(header());
    }
}

const bus::schema::VolumeHeader& KnownVolume::header() const {
    return *volume_->header.as<bus::schema::VolumeHeader>();
}

std::string KnownVolume::need(int first, int last) {
    if (!volume_) {
        return "no trace holds the volume's header";
    }
    std::string missing;
    for (int z = std::max(first, 0); z <= std::min(last, shape_.nz - 1); ++z) {
        if (volume_->slice[static_cast<std::size_t>(z)] == nullptr) {
            missing += fmt::format("{}{}", missing.empty() ? "" : ", ", z);
        }
    }
    if (missing.empty()) {
        return {};
    }
    if (held_ != nullptr && fits(*held_)) {
        values_from_ = "the session's volume";
        take_slices(*held_);
        return {};
    }
    return build_again(missing);
}

std::string KnownVolume::build_again(const std::string& missing) {
    const std::string source = header().source() == nullptr ? "" : header().source()->str();
    const std::string lacking = fmt::format("no trace holds slices {} of volume '{}'", missing,
                                            header().name()->string_view());
    if (!is_phantom(source)) {
        return fmt::format("{}; it was read from '{}', which is not read again", lacking, source);
    }
    Volume built;
    try {
        built = make_phantom(source, static_cast<int>(header().frame()));
    } catch (const std::invalid_argument& error) {
        return fmt::format("{}; {}", lacking, error.what());
    }
    if (!fits(built)) {
        return fmt::format("{}; {} as this program builds it has another size", lacking, source);
    }
    Digest digest;
    digest.add(built.values);
    if (digest.value() != header().digest()) {
        return fmt::format(
            "{}; {} as this program builds it has digest {:016x}, the recorded "
            "volume {:016x}",
            lacking, source, digest.value(), header().digest());
    }
    built_ = std::move(built);
    values_from_ = source + ", built again";
    take_slices(*built_);
    return {};
}

bool KnownVolume::fits(const Volume& volume) const {
    return volume.values.size() ==
           shape_.slice_voxels() * static_cast<std::size_t>(shape_.nz) * size_bytes(shape_.type);
}

void KnownVolume::take_slices(const Volume& volume) {
    const std::size_t size_bytes = volume.values.size() / static_cast<std::size_t>(shape_.nz);
    for (std::size_t z = 0; z < volume_->slice.size(); ++z) {
        volume_->slice[z] =
            reinterpret_cast<const std::uint8_t*>(volume.values.data()) + z * size_bytes;
    }
}

double KnownVolume::value(int x, int y, int z) const {
    const std::optional<double> value = volume_->value(x, y, z);
    if (!value) {
        throw std::out_of_range(fmt::format("voxel ({}, {}, {}) is not known", x, y, z));
    }
    return *value;
}

std::span<const std::byte> KnownVolume::slice(int z) const {
    const std::uint8_t* values = volume_->slice.at(static_cast<std::size_t>(z));
    if (values == nullptr) {
        throw std::out_of_range(fmt::format("slice {} is not known", z));
    }
    return {reinterpret_cast<const std::byte*>(values),
            shape_.slice_voxels() * size_bytes(shape_.type)};
}

}  // namespace pxpl5::host::inspect
