#include "renderer_firmware/fast/fast.hpp"

#include <cassert>

namespace pxpl5::renderer::fast {

namespace {

std::size_t index_of(int x, int y) {
    assert(x >= 0 && x < region_px && y >= 0 && y < region_px);
    return hal::pixel_index({static_cast<std::size_t>(x), static_cast<std::size_t>(y)});
}

}  // namespace

Fast::Fast(const Backend& code)
    : code_(code), board_(std::make_unique<hal::Board>()), stretch_(code) {}

void Fast::reset() {
    reset_pixels();
    board_->store.clear();
}

void Fast::reset_pixels() {
    board_->pixels.clear();
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
    const isa::Taken taken = stretch_.gather(words);
    if (taken.words != 0) {
        stretch_.run(*board_);
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
