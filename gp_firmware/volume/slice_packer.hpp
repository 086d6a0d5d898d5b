// Compression of a slice's values.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace pxpl5::gp {

/// Compresses slices without loss, and restores them: differences along x, their bytes sorted by
/// place, then zstd. Keeps its working memory from one slice to the next.
class SlicePacker {
  public:
    /// value_bytes  Size of a value: 1, 2 or 4.
    explicit SlicePacker(std::size_t value_bytes);
    ~SlicePacker();
    SlicePacker(const SlicePacker&) = delete;
    SlicePacker& operator=(const SlicePacker&) = delete;

    std::vector<std::byte> pack(std::span<const std::byte> values);
    /// Frees memory that only pack() uses. A later pack() takes it again.
    void end_packing() { bound_ = {}; }
    /// values  As many bytes as pack() took.
    /// Throws  std::logic_error if `packed` does not come from pack().
    void unpack(std::span<const std::byte> packed, std::span<std::byte> values);

  private:
    struct Contexts;
    std::unique_ptr<Contexts> contexts_;
    std::size_t value_bytes_;
    std::vector<std::byte> sorted_, bound_;
};

}  // namespace pxpl5::gp
