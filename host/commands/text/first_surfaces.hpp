// Chooses the first surfaces of a volume.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/volume/volume.hpp"

namespace pxpl5::host {

struct FirstSurface {
    std::string name;
    std::optional<double> isovalue;  ///< None if the volume and the name say it: see `surface`.
    bool seen_through = false;       ///< It lies around the first.
    friend bool operator==(const FirstSurface&, const FirstSurface&) = default;
};

/// A built-in volume's first suggestion and its skin; bone and skin of a CT whose values have them;
/// of any other volume the surface at first_isovalue(). One at least.
std::vector<FirstSurface> first_surfaces(const Volume& volume);

}  // namespace pxpl5::host
