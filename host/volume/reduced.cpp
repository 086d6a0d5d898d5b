#include "host/volume/reduced.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstdint>

#include "host/base/error.hpp"

namespace pxpl5::host {

namespace {

std::string remedy_for(const Volume& volume) {
    const std::uint64_t voxels = static_cast<std::uint64_t>(volume.nx) *
                                 static_cast<std::uint64_t>(volume.ny) *
                                 static_cast<std::uint64_t>(volume.nz);
    const std::size_t stored = volume.stored ? component_bytes(volume.stored->component) : 0;
    const std::uint64_t bytes = voxels * std::max(stored, size_bytes(volume.type));
    return bytes <= max_volume_bytes
               ? "Load with read=host, or a part with crop="
               : fmt::format(
                     "The volume has {} bytes, and the host reads at most {}. Write the "
                     "part that is needed to a file first, and load that file",
                     bytes, max_volume_bytes);
}

}  // namespace

void require_all_voxels(const Volume& volume, const std::string& what) {
    if (volume.reduced) {
        throw RequestError(
            ExitCode::failed,
            fmt::format("{} needs all voxels of {}, but the host keeps one in {} along each axis, "
                        "because the GPs read the file. {}",
                        what, volume.name, volume.reduction, remedy_for(volume)));
    }
}

}  // namespace pxpl5::host
