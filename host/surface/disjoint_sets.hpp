// Sets of numbers that are joined pairwise.
#pragma once

#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace pxpl5::host {

/// The root of a set is its lowest number, so that results do not depend on the order of joining.
class DisjointSets {
  public:
    explicit DisjointSets(std::size_t count) : parents_(count) {
        std::iota(parents_.begin(), parents_.end(), std::uint32_t{0});
    }
    std::uint32_t root(std::uint32_t i) {
        while (parents_[i] != i) i = parents_[i] = parents_[parents_[i]];
        return i;
    }
    /// Returns whether they were apart.
    bool join(std::uint32_t a, std::uint32_t b) {
        a = root(a);
        b = root(b);
        if (a == b) return false;
        if (a > b) std::swap(a, b);
        parents_[b] = a;
        return true;
    }

  private:
    std::vector<std::uint32_t> parents_;
};

}  // namespace pxpl5::host
