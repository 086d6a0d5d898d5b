#include "tests/fuzz/imported.hpp"

#include <cmath>
#include <limits>

#include "host/io/import.hpp"
#include "host/volume/scalar_types.hpp"
#include "host/volume/volume_messages.hpp"
#include "ringbus/ranges.hpp"

namespace pxpl5::fuzz {

namespace {

using host::Volume;

/// Checks minimum and maximum over the finite values.
template <typename T>
void check_range(const Volume& volume) {
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (std::size_t at = 0; at < volume.values.size(); at += sizeof(T)) {
        T value;
        std::memcpy(&value, volume.values.data() + at, sizeof value);
        if (std::isfinite(static_cast<double>(value))) {
            least = std::min(least, static_cast<double>(value));
            most = std::max(most, static_cast<double>(value));
        }
    }
    require(volume.minimum == least && volume.maximum == most, "the range of the values");
}

void check_volume(const Volume& volume) {
    require(volume.nx > 0 && volume.ny > 0 && volume.nz > 0, "sizes above 0");
    require(volume.values.size() ==
                static_cast<std::size_t>(volume.nx) * static_cast<std::size_t>(volume.ny) *
                    static_cast<std::size_t>(volume.nz) * size_bytes(volume.type),
            "the number of values");
    host::with_scalar(volume.type, [&]<typename T>(T*) { check_range<T>(volume); });
    const bus::Payload header = host::volume_header(volume, 1);
    const std::string refused =
        bus::out_of_range(*bus::schema::GetMessage(header.bytes().data()), header.bytes().size());
    require(refused.empty(), "the ring refuses the volume: " + refused);
}

}  // namespace

void add_processing(Bytes& bytes, host::io::ImportRequest& request) {
    const auto choice = bytes.take<std::uint8_t>();
    const auto three = [&](std::uint32_t least) {
        std::array<std::uint32_t, 3> values{};
        for (std::uint32_t& value : values) {
            value = least + bytes.take<std::uint8_t>() % 16;
        }
        return values;
    };
    if ((choice & 1U) != 0) {
        request.crop_first = three(0);
        request.crop_size = three(1);
    }
    if ((choice & 2U) != 0) {
        request.resample_size = three(2);
    } else if ((choice & 4U) != 0) {
        constexpr double coarse_mm = 50;  // Finer ones could ask for any number of voxels.
        request.resample_spacing_mm = glm::dvec3(coarse_mm + bytes.take<std::uint8_t>());
    }
    request.smooth_mm = (choice & 8U) != 0 ? bytes.take<std::uint8_t>() / 128.0 : 0;
    if ((choice & 16U) != 0) {
        request.spacing_mm = glm::dvec3(1, 2, 3);
    }
    request.frame = (choice & 128U) != 0 ? bytes.take<std::uint8_t>() : 0;
    if ((choice & 32U) != 0) {
        request.orientation = (choice & 64U) != 0 ? "RAI" : "PSL";
        request.origin_mm = glm::dvec3(-10, 20, 30.5);
    }
}

bool imports(const host::io::ImportRequest& request) {
    try {
        check_volume(host::io::import_volume(request));
        return true;
    } catch (const host::io::ImportError& error) {
        const std::string text = error.what();
        const std::string folder = request.path.substr(0, request.path.rfind('/'));
        require(text.starts_with(folder), "a refusal without the file: " + text);
        require(!text.ends_with("does not fit in the memory that the io process may use"), text);
        return false;
    }
}

}  // namespace pxpl5::fuzz
