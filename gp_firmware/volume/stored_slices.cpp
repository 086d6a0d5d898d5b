#include "gp_firmware/volume/stored_slices.hpp"

#include <algorithm>
#include <cstring>
#include <iomanip>
#include <limits>
#include <sstream>
#include <string>

namespace pxpl5::gp {

namespace {

struct ValueRange {
    double least = 0, greatest = 0;
};

/// Any value is a float32 voxel.
ValueRange range_of(Scalar type) {
    const auto limits = []<typename T>(T) {
        return ValueRange{static_cast<double>(std::numeric_limits<T>::lowest()),
                          static_cast<double>(std::numeric_limits<T>::max())};
    };
    return type == Scalar::uint8    ? limits(std::uint8_t{})
           : type == Scalar::int16  ? limits(std::int16_t{})
           : type == Scalar::uint16 ? limits(std::uint16_t{})
                                    : limits(float{});
}

std::string short_text(double value) {
    std::ostringstream text;
    text << std::setprecision(9) << value;
    return text.str();
}

std::string text_of(const ValueRange& range) {
    return short_text(range.least) + " to " + short_text(range.greatest);
}

/// The first value outside of the range. `stored` is in this machine's byte order.
std::string first_misfit(std::span<const std::byte> stored, Component component,
                         const StoredScale& scale, const ValueRange& range) {
    return with_type(component, [&]<typename From>(From*) {
        double value = 0;
        for (std::size_t at = 0; at + sizeof(From) <= stored.size(); at += sizeof(From)) {
            From from{};
            std::memcpy(&from, stored.data() + at, sizeof from);
            value = scaled(from, scale);
            if (!(value >= range.least && value <= range.greatest)) {
                break;
            }
        }
        return short_text(value);
    });
}

}  // namespace

StoredSlices::StoredSlices(const VolumeShape& shape, const StoredVolume& stored)
    : stored_(stored),
      type_(shape.type),
      values_(shape.slice_voxels() * component_bytes(stored.component)),
      voxels_(shape.slice_voxels() * size_bytes(shape.type)) {
    std::uint32_t first = 0;
    for (const SlicesFile& file : stored_.files) {
        firsts_.push_back(first);
        first += file.slices;
    }
}

StoredSlices::Place StoredSlices::place_of(int z) const {
    const auto slice = static_cast<std::uint32_t>(z);
    const auto next = std::upper_bound(firsts_.begin(), firsts_.end(), slice);
    return {static_cast<std::size_t>(next - firsts_.begin()) - 1, slice - *(next - 1)};
}

const SlicesFile& StoredSlices::open(std::size_t file) {
    const SlicesFile& wanted = stored_.files[file];
    const bool is_same = opened_ && wanted.path == stored_.files[open_].path &&
                         wanted.facts == stored_.files[open_].facts;
    if (!is_same) {
        if (opened_) {
            opened_->check();
        }
        opened_.emplace(wanted.path, wanted.facts);
    }
    open_ = file;
    return wanted;
}

std::span<const std::byte> StoredSlices::read(int z) {
    const Place place = place_of(z);
    const SlicesFile& file = open(place.file);
    opened_->read(file.offset_bytes + std::uint64_t{place.slice} * values_.size(), values_);
    read_stored(values_, stored_);
    if (!convert_stored(values_, stored_.component, file.scale, type_, voxels_)) {
        const ValueRange range = range_of(type_);
        throw StoredFileError(file.path + ": slice " + std::to_string(z) + " has the value " +
                              first_misfit(values_, stored_.component, file.scale, range) +
                              ", but " + enum_name(type_) + " voxels have " + text_of(range) +
                              ". The file has changed since the host loaded it. Load it again");
    }
    return voxels_;
}

}  // namespace pxpl5::gp
