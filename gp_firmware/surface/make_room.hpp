// Lists of a mesh that grow during extraction.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace pxpl5::gp {

template <class T>
[[gnu::noinline]] void grow(std::vector<T>& elements, std::size_t count) {
    if (count > elements.capacity()) {
        elements.reserve(std::max(count, 2 * elements.capacity()));
    }
    elements.resize(std::min(std::max(count, elements.size() / 4 * 5), elements.capacity()));
}

/// Makes room for `count` elements by doubling; never shrinks. Elements beyond those in use keep
/// the values of an earlier surface, so that few elements are cleared.
template <class T>
void make_room(std::vector<T>& elements, std::size_t count) {
    if (elements.size() < count) [[unlikely]] {
        grow(elements, count);
    }
}

}  // namespace pxpl5::gp
