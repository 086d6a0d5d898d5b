#include "host/phigs/colors.hpp"

#include <map>
#include <tuple>

namespace pxpl5::host::phigs {

namespace {

/// The upper `bits` of 8, spread over 0..255.
std::uint8_t rounded(std::uint8_t value, int bits) {
    const int levels = (1 << bits) - 1;
    return static_cast<std::uint8_t>(((value >> (8 - bits)) * 255 + levels / 2) / levels);
}

}  // namespace

int merge_colors(std::vector<Material>& materials, std::vector<Part>& parts) {
    int bits = 8;
    std::vector<Material> merged = materials;
    std::vector<std::size_t> new_index(materials.size());
    while (merged.size() > max_surfaces) {
        --bits;  // Two bits leave 64 colors, culled or not 128: this ends.
        std::map<std::tuple<int, int, int, bool>, std::size_t> index;
        merged.clear();
        for (std::size_t i = 0; i < materials.size(); ++i) {
            const Color& c = materials[i].color;
            const Color few{rounded(c.r, bits), rounded(c.g, bits), rounded(c.b, bits)};
            const bool cull = materials[i].cull_back;
            const auto [found, is_new] =
                index.emplace(std::tuple(few.r, few.g, few.b, cull), merged.size());
            new_index[i] = found->second;
            if (is_new) {
                merged.push_back({few, cull});
            }
        }
    }
    if (bits < 8) {
        for (Part& part : parts) {
            part.material = new_index[part.material];
        }
        materials = std::move(merged);
    }
    return bits;
}

}  // namespace pxpl5::host::phigs
