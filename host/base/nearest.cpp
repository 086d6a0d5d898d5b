#include "host/base/nearest.hpp"

#include <algorithm>

#include "isa/nearest.hpp"

namespace pxpl5::host {

using isa::edit_distance;

std::string_view nearest(std::string_view word, std::span<const std::string_view> candidates) {
    const auto found = std::min_element(candidates.begin(), candidates.end(),
                                        [word](std::string_view p, std::string_view q) {
                                            return edit_distance(word, p) < edit_distance(word, q);
                                        });
    return found == candidates.end() ? std::string_view{} : *found;
}

std::string did_you_mean(std::string_view word, std::span<const std::string_view> candidates) {
    const std::string_view best = nearest(word, candidates);
    if (!best.empty() && best != word &&
        edit_distance(word, best) <= std::max<std::size_t>(2, best.size() / 3)) {
        return "; did you mean '" + std::string(best) + "'?";
    }
    std::string known = "; known:";
    for (const std::string_view candidate : candidates) {
        known += (candidate == candidates.front() ? " " : ", ") + std::string(candidate);
    }
    return known;
}

}  // namespace pxpl5::host
