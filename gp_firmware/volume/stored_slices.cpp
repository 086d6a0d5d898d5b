#include "gp_firmware/volume/stored_slices.hpp"

#include <cstring>
#include <iomanip>
#include <limits>
#include <sstream>
#include <string>

namespace pxpl5::gp {

namespace {

struct Range {
    double least = 0, greatest = 0;
};

/// Any value is a float32 voxel.
Range range_of(Scalar type) {
    const auto limits = []<typename T>(T) {
        return Range{static_cast<double>(std::numeric_limits<T>::lowest()),
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

std::string text_of(const Range& range) {
    return short_text(range.least) + " to " + short_text(range.greatest);
}

/// The first value outside of the range. `stored` is in this machine's byte order.
std::string first_misfit(std::span<const std::byte> stored, const SlicesFile& file,
                         const Range& range) {
    return with_type(file.stored, [&]<typename From>(From*) {
        double value = 0;
        for (std::size_t at = 0; at + sizeof(From) <= stored.size(); at += sizeof(From)) {
            From from{};
            std::memcpy(&from, stored.data() + at, sizeof from);
            value = scaled(from, file.scale);
            if (!(value >= range.least && value <= range.greatest)) {
                break;
            }
        }
        return short_text(value);
    });
}

}  // namespace

StoredSlices::StoredSlices(const VolumeShape& shape, const SlicesFile& file)
    : file_(file),
      type_(shape.type),
      opened_(file.path, file.facts),
      stored_(shape.slice_voxels() * component_bytes(file.stored)),
      voxels_(shape.slice_voxels() * size_bytes(shape.type)) {}

std::span<const std::byte> StoredSlices::read(int z) {
    opened_.read(file_.offset_bytes + static_cast<std::uint64_t>(z) * stored_.size(), stored_);
    if (!convert_stored(stored_, file_, type_, voxels_)) {
        throw StoredFileError(file_.path + ": slice " + std::to_string(z) + " has the value " +
                              first_misfit(stored_, file_, range_of(type_)) + ", but " +
                              enum_name(type_) + " voxels have " + text_of(range_of(type_)) +
                              ". The file has changed since the host loaded it. Load it again");
    }
    return voxels_;
}

}  // namespace pxpl5::gp
