#include "host/commands/text/tissues.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace pxpl5::host {

std::span<const Tissue> tissues() {
    static constexpr std::array<Tissue, 7> table = {{
        {"lung", -600.5, {214, 160, 160}, "air-filled tissue against the chest's soft parts"},
        {"skin", -300.5, {233, 190, 160}, "the body against the air around it"},
        {"fat", -150.5, {240, 214, 140}, "outside of fat"},
        {"muscle", 0.5, {196, 96, 84}, "between fat and muscle"},
        {"bone", 200.5, {236, 226, 200}, "all bone; contrast-filled vessels too"},
        {"cortex", 500.5, {246, 240, 224}, "dense bone and teeth"},
        {"metal", 2200.5, {190, 200, 214}, "implants, fillings"},
    }};
    return table;
}

std::string refusal_of_tissue(std::string_view tissue, std::string_view modality) {
    if (modality.empty() || modality == "CT") {
        return {};
    }
    return fmt::format(
        "preset={} is an isovalue in Hounsfield units, and this volume is {}, no CT: give iso=V; "
        "'histogram' and 'atlas' show which values part its tissues",
        tissue, modality);
}

const Tissue* find_tissue(std::string_view name) {
    const auto found = std::ranges::find(tissues(), name, &Tissue::name);
    return found == tissues().end() ? nullptr : &*found;
}

}  // namespace pxpl5::host
