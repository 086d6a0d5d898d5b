// The first bit in which two executors differ, over all that an instruction can see.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "isa/executor.hpp"

namespace pxpl5::host::inspect {

/// One bit of one pixel.
struct StateBit {
    enum class Where : std::uint8_t { memory, enable, carry, backing, readout };
    int x = 0, y = 0;  ///< In the region.
    Where where = Where::memory;
    std::uint32_t bit = 0;    ///< m[bit], or the bit of the block or of the word read out.
    std::uint32_t block = 0;  ///< Block of the backing store.
};

/// Two executors whose readouts are kept. Both outlive it; it takes their readout sinks.
class ExecutorPair {
  public:
    ExecutorPair(isa::Executor& first, isa::Executor& second);
    ~ExecutorPair();
    ExecutorPair(const ExecutorPair&) = delete;
    ExecutorPair& operator=(const ExecutorPair&) = delete;

    /// Pixel after pixel, row by row; in a pixel enable, carry, memory, blocks, readout.
    ///
    /// blocks  Of the backing store, that are looked at.
    std::optional<StateBit> difference(const std::vector<std::uint32_t>& blocks) const;
    /// Likewise, of one pixel.
    std::optional<StateBit> pixel_difference(int x, int y,
                                             const std::vector<std::uint32_t>& blocks) const;

    isa::Executor& first() const { return first_; }
    isa::Executor& second() const { return second_; }
    /// The word that an executor has read out last at a pixel; 0 if it has not.
    std::uint32_t read_out(bool second, int x, int y) const;

  private:
    isa::Executor &first_, &second_;
    std::vector<std::uint32_t> first_readout_, second_readout_;
};

/// A field that holds a bit of pixel memory: of the region layout, or bits around.
struct NamedBits {
    std::string name;  ///< "z"; "m[96 : 128)" where the layout has no name.
    std::uint32_t address = 0, width = 0;
};
NamedBits field_of(std::uint32_t bit);

/// Value of what holds the bit: a named field, the enable, the carry, a block or a readout word.
std::uint64_t value_at(const ExecutorPair& pair, bool second, const StateBit& bit);

/// "z, bit 3 (m[11])", "enable", "carry", "block 4, bit 0", "readout, bit 9".
std::string to_text(const StateBit& bit);

/// Backing-store blocks that `words`, a checked program, read or write; ascending.
std::vector<std::uint32_t> blocks_of(std::span<const std::uint32_t> words);

}  // namespace pxpl5::host::inspect
