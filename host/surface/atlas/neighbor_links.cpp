#include "host/surface/atlas/neighbor_links.hpp"

#include <cstdlib>
#include <memory>

namespace pxpl5::host {

namespace {

using Steps = std::array<std::array<int, 3>, neighbor_count>;

Steps make_steps() {
    Steps steps{};
    std::size_t count = 0;
    for (const int length : {1, 2}) {
        for (int cell = 0; cell < 27; ++cell) {
            const int x = cell % 3 - 1, y = cell / 3 % 3 - 1, z = cell / 9 - 1;
            if (std::abs(x) + std::abs(y) + std::abs(z) == length) {
                steps[count++] = {x, y, z};
            }
        }
    }
    return steps;
}

/// Per neighbor, the neighbors that a voxel there is joined to, if both are on the side.
std::array<std::uint32_t, neighbor_count> joined_neighbors(Side side) {
    const int greatest_length = side == Side::inside ? 1 : 2;
    const Steps& steps = neighbor_steps();
    std::array<std::uint32_t, neighbor_count> joined{};
    for (std::size_t a = 0; a < neighbor_count; ++a) {
        for (std::size_t b = 0; b < neighbor_count; ++b) {
            int length = 0, greatest = 0;
            for (std::size_t i = 0; i < 3; ++i) {
                const int distance = std::abs(steps[a][i] - steps[b][i]);
                length += distance;
                greatest = distance > greatest ? distance : greatest;
            }
            if (greatest == 1 && length <= greatest_length) joined[a] |= 1U << b;
        }
    }
    return joined;
}

std::unique_ptr<const LinkTable> make_table(Side side) {
    const auto joined = joined_neighbors(side);
    auto table = std::make_unique<LinkTable>();
    for (std::uint32_t set = 0; set < table->size(); ++set) {
        const std::uint32_t joining = set & joining_links(side);
        std::uint32_t reached = joining & (~joining + 1), before = 0;
        while (reached != before) {
            before = reached;
            for (std::size_t k = 0; k < neighbor_count; ++k)
                if ((reached >> k & 1) != 0) reached |= joined[k] & set;
        }
        table->set(set, (joining & ~reached) == 0);
    }
    return table;
}

}  // namespace

const Steps& neighbor_steps() {
    static const Steps steps = make_steps();
    return steps;
}

const LinkTable& link_table(Side side) {
    static const auto inside = make_table(Side::inside), outside = make_table(Side::outside);
    return side == Side::inside ? *inside : *outside;
}

}  // namespace pxpl5::host
