#include "host/commands/text/tissues.hpp"

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

const Tissue* find_tissue(std::string_view name) {
    const auto found = std::ranges::find(tissues(), name, &Tissue::name);
    return found == tissues().end() ? nullptr : &*found;
}

}  // namespace pxpl5::host
