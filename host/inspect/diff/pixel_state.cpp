#include "host/inspect/diff/pixel_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "isa/contract/region_layout.hpp"
#include "isa/program.hpp"

namespace pxpl5::host::inspect {

namespace {

constexpr std::uint32_t step = 52;  ///< Bits compared at once; 208 are four steps.
static_assert(isa::memory_bits % step == 0);

struct LayoutRow {
    isa::region::Field field;
    const char* name;
};
constexpr std::array<LayoutRow, 6> layout = {{{isa::region::surface, "surface"},
                                              {isa::region::z, "z"},
                                              {isa::region::normal_x, "normal_x"},
                                              {isa::region::normal_y, "normal_y"},
                                              {isa::region::normal_z, "normal_z"},
                                              {isa::region::rgb, "rgb"}}};

std::uint32_t lowest(std::uint64_t p, std::uint64_t q) {
    return static_cast<std::uint32_t>(std::countr_zero(p ^ q));
}

std::uint32_t word_at(const std::vector<std::uint32_t>& words, int x, int y) {
    const auto at = static_cast<std::size_t>(y * region_px + x);
    return at < words.size() ? words[at] : 0;
}

}  // namespace

ExecutorPair::ExecutorPair(isa::Executor& first, isa::Executor& second)
    : first_(first), second_(second) {
    first_.set_readout([this](auto words) { first_readout_.assign(words.begin(), words.end()); });
    second_.set_readout([this](auto words) { second_readout_.assign(words.begin(), words.end()); });
}

ExecutorPair::~ExecutorPair() {
    first_.set_readout({});
    second_.set_readout({});
}

std::uint32_t ExecutorPair::read_out(bool second, int x, int y) const {
    return word_at(second ? second_readout_ : first_readout_, x, y);
}

std::optional<StateBit> ExecutorPair::pixel_difference(
    int x, int y, const std::vector<std::uint32_t>& blocks) const {
    using Where = StateBit::Where;
    if (first_.enabled(x, y) != second_.enabled(x, y)) {
        return StateBit{x, y, Where::enable};
    }
    if (first_.carry(x, y) != second_.carry(x, y)) {
        return StateBit{x, y, Where::carry};
    }
    for (std::uint32_t a = 0; a < isa::memory_bits; a += step) {
        const std::uint64_t p = first_.field(x, y, a, step), q = second_.field(x, y, a, step);
        if (p != q) {
            return StateBit{x, y, Where::memory, a + lowest(p, q)};
        }
    }
    for (const std::uint32_t block : blocks) {
        const std::uint32_t p = first_.backing_block(x, y, block),
                            q = second_.backing_block(x, y, block);
        if (p != q) {
            return StateBit{x, y, Where::backing, lowest(p, q), block};
        }
    }
    const std::uint32_t p = read_out(false, x, y), q = read_out(true, x, y);
    if (p != q) {
        return StateBit{x, y, Where::readout, lowest(p, q)};
    }
    return std::nullopt;
}

std::optional<StateBit> ExecutorPair::difference(const std::vector<std::uint32_t>& blocks) const {
    for (int y = 0; y < region_px; ++y) {
        for (int x = 0; x < region_px; ++x) {
            if (const auto bit = pixel_difference(x, y, blocks)) {
                return bit;
            }
        }
    }
    return std::nullopt;
}

NamedBits field_of(std::uint32_t bit) {
    for (const LayoutRow& row : layout) {
        if (bit >= row.field.address && bit < row.field.address + row.field.width) {
            return {row.name, row.field.address, row.field.width};
        }
    }
    const std::uint32_t first = bit / 16 * 16;
    return {fmt::format("m[{} : {})", first, first + 16), first, 16};
}

std::uint64_t value_at(const ExecutorPair& pair, bool second, const StateBit& bit) {
    const isa::Executor& executor = second ? pair.second() : pair.first();
    switch (bit.where) {
        case StateBit::Where::enable:
            return executor.enabled(bit.x, bit.y) ? 1 : 0;
        case StateBit::Where::carry:
            return executor.carry(bit.x, bit.y) ? 1 : 0;
        case StateBit::Where::backing:
            return executor.backing_block(bit.x, bit.y, bit.block);
        case StateBit::Where::readout:
            return pair.read_out(second, bit.x, bit.y);
        case StateBit::Where::memory:
            break;
    }
    const NamedBits field = field_of(bit.bit);
    return executor.field(bit.x, bit.y, field.address, field.width);
}

std::string to_text(const StateBit& bit) {
    switch (bit.where) {
        case StateBit::Where::enable:
            return "enable";
        case StateBit::Where::carry:
            return "carry";
        case StateBit::Where::backing:
            return fmt::format("backing-store block {}, bit {}", bit.block, bit.bit);
        case StateBit::Where::readout:
            return fmt::format("readout, bit {}", bit.bit);
        case StateBit::Where::memory:
            break;
    }
    const NamedBits field = field_of(bit.bit);
    return fmt::format("{}, bit {} (m[{}])", field.name, bit.bit - field.address, bit.bit);
}

std::vector<std::uint32_t> blocks_of(std::span<const std::uint32_t> words) {
    std::vector<std::uint32_t> blocks;
    for (std::size_t at = 0; at < words.size(); at += isa::instruction_words(words[at])) {
        const isa::Instruction in = *isa::decode(words[at]);
        if (isa::info(in.op).b_role == isa::Role::block) {
            blocks.push_back(in.operands.b);
        }
    }
    std::ranges::sort(blocks);
    blocks.erase(std::ranges::unique(blocks).begin(), blocks.end());
    return blocks;
}

}  // namespace pxpl5::host::inspect
