// The known name that is nearest to an unknown name.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace pxpl5::host {

/// The candidate with the least edit distance to `word`; empty if there is no candidate.
std::string_view nearest(std::string_view word, std::span<const std::string_view> candidates);

/// "; did you mean 'orbit'?" where a candidate is near enough, else "; known: a, b, c". Never
/// suggests `word` itself.
std::string did_you_mean(std::string_view word, std::span<const std::string_view> candidates);

}  // namespace pxpl5::host
