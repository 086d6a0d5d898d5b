#include "host/base/nearest.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

namespace pxpl5::host {

namespace {

/// Levenshtein distance: insertions, deletions and replacements that turn `a` into `b`.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
        }
    }
    return row.back();
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
    const std::string_view best = nearest(word, candidates);
    if (!best.empty() && edit_distance(word, best) <= std::max<std::size_t>(2, best.size() / 3)) {
        return "; did you mean '" + std::string(best) + "'?";
    }
    std::string known = "; known:";
    for (const std::string_view candidate : candidates) {
        known += (candidate == candidates.front() ? " " : ", ") + std::string(candidate);
    }
    return known;
}

}  // namespace pxpl5::host
