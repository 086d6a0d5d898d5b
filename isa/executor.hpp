// What runs instructions on pixels: the interface of the reference and of the fast executor.
//
//   words --> sequencer --> Executor::execute --> 128 x 128 pixels --> readout sink (PIXELSTOFB)
//             (control rows)  (all other rows)
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>

#include "isa/instruction.hpp"
#include "isa/region.hpp"

namespace pxpl5::isa {

inline constexpr std::uint32_t memory_bits = 208;     ///< Per pixel, on chip.
inline constexpr std::uint32_t backing_blocks = 128;  ///< Per pixel, 32 bits each.
inline constexpr std::uint32_t backing_block_bits = 32;

/// Coefficient words of one instruction: 0, 1 (K), 3 (A B C) or 6 (A B C D E F).
using Coefficients = std::span<const std::int32_t>;

/// Takes one word per pixel, row by row (index y * 128 + x), when a program reads out. The span is
/// valid during the call only.
using ReadoutSink = std::function<void(std::span<const std::uint32_t>)>;

/// What an executor ran by itself, ahead of the sequencer.
struct Taken {
    std::size_t words = 0;  ///< 0: nothing, the sequencer goes on instruction by instruction.
    std::size_t instructions = 0;
    std::uint64_t cycles = 0;  ///< Sum of the rows' cycles.
};

/// 128 x 128 pixels with their memories, enables, carries and backing store. Instructions have
/// passed check(); executing anything else is a bug of the caller.
class Executor {
  public:
    Executor() = default;
    Executor(const Executor&) = delete;
    Executor& operator=(const Executor&) = delete;
    virtual ~Executor() = default;

    /// Runs one instruction, any but the control rows (OpInfo::is_control).
    virtual void execute(Instruction in, Coefficients coefficients) = 0;

    /// Offered before each instruction: may run a prefix of `words` (the rest of a checked program)
    /// that holds no control row, with the same result as instruction by instruction.
    virtual Taken execute_ahead([[maybe_unused]] std::span<const std::uint32_t> words) {
        return {};
    }

    /// The global OR of the enable bits.
    virtual bool any_enabled() const = 0;

    /// Field m[a : a+n) of pixel (x, y), zero-extended; n is 1..64.
    virtual std::uint64_t field(int x, int y, std::uint32_t a, std::uint32_t n) const = 0;
    virtual bool enabled(int x, int y) const = 0;
    virtual bool carry(int x, int y) const = 0;
    /// Backing-store block `block` of pixel (x, y). A block never written holds 0.
    virtual std::uint32_t backing_block(int x, int y, std::uint32_t block) const = 0;

    void set_readout(ReadoutSink sink) { readout_ = std::move(sink); }

  protected:
    /// Called by PIXELSTOFB; without a sink the pixels are dropped.
    void read_out(std::span<const std::uint32_t> pixels) const {
        if (readout_) {
            readout_(pixels);
        }
    }

  private:
    ReadoutSink readout_;
};

/// An executor whose pixels can be kept and brought back, everything that an instruction could
/// ever see: memory, enables, carries, backing store.
template <typename E>
concept Restorable = std::derived_from<E, Executor> && requires(E executor, const E& constant) {
    { constant.save() } -> std::same_as<typename E::State>;
    executor.restore(constant.save());
};

}  // namespace pxpl5::isa
