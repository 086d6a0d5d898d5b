#include "isa/nearest.hpp"

#include <algorithm>
#include <cctype>
#include <numeric>
#include <vector>

namespace pxpl5::isa {
namespace {

bool same_letter(char a, char b) {
    const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
    return lower(a) == lower(b);
}

}  // namespace

std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = diagonal + (same_letter(a[i - 1], b[j - 1]) ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
        }
    }
    return row.back();
}

std::string_view nearest(std::string_view word, std::span<const std::string_view> candidates) {
    const auto distance = [word](std::string_view known) { return edit_distance(word, known); };
    const auto found = std::ranges::min_element(candidates, {}, distance);
    if (found == candidates.end()) {
        return {};
    }
    const std::size_t limit = std::max<std::size_t>(2, found->size() / 3);
    return distance(*found) <= limit ? *found : std::string_view{};
}

}  // namespace pxpl5::isa
