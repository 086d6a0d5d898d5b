#include "host/volume/identity.hpp"

#include <fmt/core.h>

#include <span>

#include "host/base/digest.hpp"

namespace pxpl5::host {

std::uint64_t place_digest(const Volume& volume) {
    std::vector<double> numbers = {static_cast<double>(volume.nx), static_cast<double>(volume.ny),
                                   static_cast<double>(volume.nz)};
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 4; ++row) {
            numbers.push_back(volume.voxel_to_patient[column][row]);
        }
    }
    numbers.insert(numbers.end(), volume.slice_places.begin(), volume.slice_places.end());
    for (double& number : numbers) {
        number += 0.0;  // -0 and 0 are the same place.
    }
    Digest digest;
    digest.add(std::as_bytes(std::span(numbers)));
    return digest.value();
}

std::string identity_of(const Volume& volume) {
    return fmt::format("{:016x}-{:016x}-{}", volume.digest, place_digest(volume), volume.series);
}

std::string series_identity_of(const Volume& volume, int load) {
    return volume.frames == 1
               ? identity_of(volume)
               : fmt::format("{} {:016x}-{}", load, place_digest(volume), volume.source);
}

}  // namespace pxpl5::host
