#include "renderer_firmware/fast/fast.hpp"

#include <cassert>

#include "isa/program.hpp"

namespace pxpl5::renderer::fast {

namespace {

/// Blocks that run a stretch together: 14 KB of pixel memory, under half of a first-level cache.
constexpr std::size_t group_blocks = 4;
static_assert(hal::block_count % group_blocks == 0);

/// Instructions of one stretch; more than one stretch does no harm.
constexpr std::size_t max_steps = 1024;

std::size_t index_of(int x, int y) {
    assert(x >= 0 && x < isa::region::size_px && y >= 0 && y < isa::region::size_px);
    return hal::pixel_index({static_cast<std::size_t>(x), static_cast<std::size_t>(y)});
}

isa::Coefficients coefficients_at(std::span<const std::uint32_t> words, std::size_t first,
                                  std::size_t count) {
    // int32_t and uint32_t may alias.
    return {reinterpret_cast<const std::int32_t*>(words.data()) + first, count};
}

}  // namespace

Fast::Fast(const Backend& code) : code_(code), board_(std::make_unique<hal::Board>()) {
    steps_.reserve(max_steps);
}

void Fast::reset() {
    board_->pixels.clear();
    board_->store.clear();
}

std::size_t Fast::State::bytes() const {
    return sizeof *pixels + blocks.size() * sizeof(hal::BackingStore::Words);
}

Fast::State Fast::save() const {
    State state{std::make_unique<const hal::PixelArray>(board_->pixels), {}};
    for (std::uint32_t number = 0; number < isa::backing_blocks; ++number) {
        if (const hal::BackingStore::Words* words = board_->store.find(number)) {
            state.blocks.emplace_back(number, *words);
        }
    }
    return state;
}

void Fast::restore(const State& state) {
    board_->pixels = *state.pixels;
    board_->store.clear();
    for (const auto& [number, words] : state.blocks) {
        board_->store.open(number) = words;
    }
}

void Fast::execute(isa::Instruction in, isa::Coefficients coefficients) {
    const Handler handler = code_.handlers[static_cast<std::size_t>(in.op)];
    assert(handler != nullptr);
    handler(*board_, {}, in.operands, coefficients);
    if (in.op == isa::Op::pixels_to_fb) {
        read_out(board_->port.rows());
    }
}

isa::Taken Fast::execute_ahead(std::span<const std::uint32_t> words) {
    const isa::Taken triangles = code_.triangles(*board_, words.data(), words.size());
    if (triangles.words != 0) {
        return triangles;
    }
    const isa::Taken taken = gather(words);
    for (std::size_t first = 0; first < hal::block_count && !steps_.empty();
         first += group_blocks) {
        for (const Step& step : steps_) {
            step.run(*board_, {first, first + group_blocks}, step.operands, step.coefficients);
        }
    }
    return taken;
}

/// Notes the straight-line stretch at the head of `words`: up to a row that the controller runs or
/// that leaves through the port, and up to what may be a triangle.
isa::Taken Fast::gather(std::span<const std::uint32_t> words) {
    steps_.clear();
    isa::Taken taken;
    while (taken.words < words.size() && steps_.size() < max_steps) {
        const isa::Instruction in = *isa::decode(words[taken.words]);
        const isa::OpInfo& row = isa::info(in.op);
        const bool may_be_triangle = in.op == isa::Op::set_enabs && !steps_.empty();
        if (row.is_control() || (row.effects & isa::port) != 0 || may_be_triangle) {
            break;
        }
        const auto count = static_cast<std::size_t>(row.words);
        steps_.push_back({code_.handlers[static_cast<std::size_t>(in.op)], in.operands,
                          coefficients_at(words, taken.words + 1, count)});
        taken.words += 1 + count;
        taken.instructions += 1;
        taken.cycles += row.cycles(in.operands);
    }
    return taken;
}

std::uint64_t Fast::field(int x, int y, std::uint32_t a, std::uint32_t n) const {
    return hal::field(board_->pixels, index_of(x, y), a, n);
}

bool Fast::enabled(int x, int y) const {
    return hal::bit_of(board_->pixels.enable, index_of(x, y));
}

bool Fast::carry(int x, int y) const {
    return hal::bit_of(board_->pixels.carry, index_of(x, y));
}

std::uint32_t Fast::backing_block(int x, int y, std::uint32_t block) const {
    assert(block < isa::backing_blocks);
    const hal::BackingStore::Words* words = board_->store.find(block);
    return words == nullptr ? 0 : words->at[index_of(x, y)];
}

}  // namespace pxpl5::renderer::fast
