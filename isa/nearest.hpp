// Finds the known name that is closest to an unknown one.
#pragma once

#include <span>
#include <string_view>

namespace pxpl5::isa {

/// Returns the number of insertions, deletions and replacements of characters that turn `a` into
/// `b`. Upper and lower case are equal.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// Returns the candidate with the smallest edit distance to `word`, the first one of several.
/// Returns an empty text if every candidate differs too much to be a likely misspelling.
std::string_view nearest(std::string_view word, std::span<const std::string_view> candidates);

}  // namespace pxpl5::isa
