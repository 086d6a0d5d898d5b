#include "host/base/nearest.hpp"

#include <algorithm>
#include <array>

#include "isa/nearest.hpp"

namespace pxpl5::host {

using isa::edit_distance;

namespace {

constexpr std::size_t shortest_prefix = 3;  ///< "surf" means "surface".

/// Words of other programs, and ours.
constexpr std::array<std::array<std::string_view, 2>, 9> synonyms = {
    {{"isovalue", "iso"},
     {"threshold", "iso"},
     {"level", "iso"},
     {"front", "anterior"},
     {"back", "posterior"},
     {"top", "superior"},
     {"bottom", "inferior"},
     {"gps", "gp.count"},
     {"renderers", "renderer.count"}}};

/// The candidate that is a synonym of `word`, both perhaps after "--". Empty if none is.
std::string_view synonym(std::string_view word, std::span<const std::string_view> candidates) {
    const auto bare = [](std::string_view name) {
        return name.starts_with("--") ? name.substr(2) : name;
    };
    for (const auto& [other, ours] : synonyms) {
        const auto found = std::ranges::find(candidates, ours, bare);
        if (other == bare(word) && found != candidates.end()) {
            return *found;
        }
    }
    return {};
}

}  // namespace

std::string_view nearest(std::string_view word, std::span<const std::string_view> candidates) {
    const auto found = std::min_element(candidates.begin(), candidates.end(),
                                        [word](std::string_view p, std::string_view q) {
                                            return edit_distance(word, p) < edit_distance(word, q);
                                        });
    return found == candidates.end() ? std::string_view{} : *found;
}

std::string did_you_mean(std::string_view word, std::span<const std::string_view> candidates) {
    if (const std::string_view same = synonym(word, candidates); !same.empty()) {
        return "; did you mean '" + std::string(same) + "'?";
    }
    const auto longer = std::ranges::find_if(candidates, [word](std::string_view candidate) {
        return word.size() >= shortest_prefix && candidate != word && candidate.starts_with(word);
    });
    const std::string_view best = longer != candidates.end() ? *longer : nearest(word, candidates);
    const bool is_near = edit_distance(word, best) <= std::max<std::size_t>(2, best.size() / 3);
    if (!best.empty() && best != word && (is_near || longer != candidates.end())) {
        return "; did you mean '" + std::string(best) + "'?";
    }
    std::string known = "; known:";
    for (const std::string_view candidate : candidates) {
        known += (candidate == candidates.front() ? " " : ", ") + std::string(candidate);
    }
    return known;
}

}  // namespace pxpl5::host
