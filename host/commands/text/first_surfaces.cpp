#include "host/commands/text/first_surfaces.hpp"

#include "host/commands/text/tissues.hpp"
#include "host/phantom/phantom.hpp"
#include "host/surface/atlas/first_isovalue.hpp"

namespace pxpl5::host {

namespace {

constexpr const char* skin = "skin";

bool has_tissue(const Volume& volume, std::string_view name) {
    const Tissue* tissue = find_tissue(name);
    return tissue != nullptr && volume.minimum < tissue->isovalue_hu &&
           volume.maximum > tissue->isovalue_hu;
}

/// A CT whose values are shifted, or cut off at either end, has not both.
bool has_bone_and_skin(const Volume& volume) {
    return volume.modality == "CT" && has_tissue(volume, "bone") && has_tissue(volume, skin);
}

}  // namespace

std::vector<FirstSurface> first_surfaces(const Volume& volume) {
    std::vector<FirstSurface> surfaces;
    for (const PhantomSurface& each : suggested_surfaces(volume.name)) {
        if (surfaces.empty() || each.name == skin) {
            surfaces.push_back({each.name, {}, !surfaces.empty()});
        }
    }
    if (surfaces.empty() && has_bone_and_skin(volume)) {
        surfaces = {{"bone", {}, false}, {skin, {}, true}};
    }
    if (surfaces.empty()) {
        surfaces = {{"surface", first_isovalue(volume), false}};
    }
    return surfaces;
}

}  // namespace pxpl5::host
