#include "host/volume/reduced.hpp"

#include <fmt/core.h>

#include "host/base/error.hpp"

namespace pxpl5::host {

void require_all_voxels(const Volume& volume, const std::string& what) {
    if (volume.reduced) {
        throw RequestError(
            ExitCode::failed,
            fmt::format("{} needs all voxels of {}, but the host keeps one in {} along each axis, "
                        "because the GPs read the file. Load with read=host, or a part "
                        "with crop=",
                        what, volume.name, volume.reduction));
    }
}

}  // namespace pxpl5::host
