// The interface of the executors, which run instructions on pixels.
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

#include "generated/vocabulary.hpp"
#include "isa/instruction.hpp"

namespace pxpl5::isa {

inline constexpr std::uint32_t memory_bits = 208;     ///< Per pixel, on chip.
inline constexpr std::uint32_t backing_blocks = 128;  ///< Per pixel, 32 bits each.
inline constexpr std::uint32_t backing_block_bits = 32;

/// Coefficient words of one instruction: 0, 1 (K), 3 (A B C) or 6 (A B C D E F).
using Coefficients = std::span<const std::int32_t>;

/// Returns the coefficient words of a program as coefficients.
inline Coefficients signed_words(std::span<const std::uint32_t> words) {
    // int32_t is the signed type of uint32_t, so reading one as the other is defined.
    return {reinterpret_cast<const std::int32_t*>(words.data()), words.size()};
}

/// Receives one word per pixel, row by row (index y * 128 + x), from PIXELSTOFB. The span is valid
/// only during the call.
using ReadoutSink = std::function<void(std::span<const std::uint32_t>)>;

/// The instructions that an executor ran ahead of the sequencer.
struct Taken {
    std::size_t words = 0;  ///< 0: none; the sequencer runs the next instruction.
    std::size_t instructions = 0;
    std::uint64_t cycles = 0;  ///< Sum of the rows' cycles.
};

/// 128 x 128 pixels with their memory, enable bits, carry bits and backing store. All instructions
/// must have passed check().
class Executor {
  public:
    Executor() = default;
    Executor(const Executor&) = delete;
    Executor& operator=(const Executor&) = delete;
    virtual ~Executor() = default;

    /// Runs one instruction that is not a control row (OpInfo::is_control).
    virtual void execute(Instruction in, Coefficients coefficients) = 0;

    /// Called before each instruction. May run a prefix of `words` (the rest of a checked program)
    /// without control rows. The result must be that of running the instructions one by one.
    virtual Taken execute_ahead([[maybe_unused]] std::span<const std::uint32_t> words) {
        return {};
    }

    /// Returns the OR of the enable bits of all pixels.
    virtual bool any_enabled() const = 0;

    /// Returns field m[a : a+n) of pixel (x, y), zero-extended; n is 1..64.
    virtual std::uint64_t field(int x, int y, std::uint32_t a, std::uint32_t n) const = 0;
    virtual bool enabled(int x, int y) const = 0;
    virtual bool carry(int x, int y) const = 0;
    /// Returns a block of the backing store of pixel (x, y); 0 if the block was never written.
    virtual std::uint32_t backing_block(int x, int y, std::uint32_t block) const = 0;

    void set_readout(ReadoutSink sink) { readout_ = std::move(sink); }

  protected:
    /// Passes the pixels of PIXELSTOFB to the sink. Drops them if there is no sink.
    void read_out(std::span<const std::uint32_t> pixels) const {
        if (readout_) {
            readout_(pixels);
        }
    }

  private:
    ReadoutSink readout_;
};

/// An executor that can save and restore all state that instructions can read: memory, enable
/// bits, carry bits and backing store.
template <typename E>
concept Restorable = std::derived_from<E, Executor> && requires(E executor, const E& constant) {
    { constant.save() } -> std::same_as<typename E::State>;
    executor.restore(constant.save());
};

}  // namespace pxpl5::isa
