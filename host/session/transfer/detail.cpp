#include "host/session/transfer/detail.hpp"

#include <fmt/core.h>

#include <cmath>

#include "ringbus/rules/slabs.hpp"

namespace pxpl5::host {

std::string simplification_refusal(const Volume& volume, int gp_count) {
    const SlabSets sets{volume.nz, volume.slabs_per_set, gp_count};
    if (sets.have_whole_blocks()) {
        return {};
    }
    return fmt::format(
        "surfaces of {} cannot be simplified: each GP has sets of {} slab{}, and a block of {} "
        "slabs must be in one of the {} GPs; start pxpl5 with --set gp.slabs_per_set={} or a "
        "multiple, or with --set gp.count=1",
        volume.name, sets.slabs_per_set, sets.slabs_per_set == 1 ? "" : "s", block_slabs, gp_count,
        block_slabs);
}

int moving_detail(std::int64_t triangles, std::int64_t most) {
    int detail = 0;
    while (detail < max_detail && triangles > (most << (2 * detail))) {
        ++detail;
    }
    return detail;
}

std::string bound_text(double mm) {
    return fmt::format("{:.3f}", std::ceil(mm * 1000) / 1000);
}

std::string detail_word(const DetailChoice& choice) {
    return choice.is_auto ? "auto" : choice.detail == 0 ? "exact" : std::to_string(choice.detail);
}

}  // namespace pxpl5::host
