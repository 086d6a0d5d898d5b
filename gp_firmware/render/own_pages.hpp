// Own pages: memory that grows without copies.
#pragma once

#include <cstddef>

namespace pxpl5::gp {

/// A block of memory for a list that only grows. Blocks of at least `least_bytes` are mapped
/// separately and grow with mremap: the kernel moves their pages and copies no bytes. No smaller
/// block is left behind in the heap, and unwritten pages use no RAM. Smaller blocks use malloc.
class OwnPages {
  public:
    static constexpr std::size_t least_bytes = std::size_t{1} << 20;

    OwnPages() = default;
    ~OwnPages();
    OwnPages(OwnPages&& other) noexcept;
    OwnPages& operator=(OwnPages&& other) noexcept;

    /// Makes the block larger. Its first `used` bytes stay; the others have any value.
    ///
    /// used   At most bytes().
    /// bytes  More than bytes(). The block may get up to a page more.
    /// Throws std::bad_alloc if there is no memory, and the block stays as it was.
    void grow(std::size_t used, std::size_t bytes);

    std::byte* data() const { return data_; }
    std::size_t bytes() const { return bytes_; }

  private:
    void free();

    std::byte* data_ = nullptr;
    std::size_t bytes_ = 0;
};

}  // namespace pxpl5::gp
