#include "renderer_firmware/fast/stretch.hpp"

namespace pxpl5::renderer::fast {

namespace {

/// Blocks that run a stretch together: 14 KB of pixel memory, less than half of a first-level
/// cache.
constexpr std::size_t group_blocks = 4;
static_assert(hal::block_count % group_blocks == 0);

constexpr std::size_t tiles_per_block = hal::block_pixels / hal::tile_pixels;

/// Limits the steps of one stretch. A longer sequence becomes several stretches.
constexpr std::size_t max_steps = 1024;

/// True if a word `word` of the tile has one of `bits` set.
bool any_has(const std::uint32_t* word, std::uint32_t bits) {
    std::uint32_t any = 0;
    for (std::size_t i = 0; i < hal::tile_pixels; ++i) {
        any |= word[i];
    }
    return (any & bits) != 0;
}

}  // namespace

Stretch::Stretch(const Backend& code) : code_(code) {
    steps_.reserve(max_steps);
}

isa::Taken Stretch::gather(std::span<const std::uint32_t> words) {
    steps_.clear();
    wakes_all_ = false;
    wake_bits_ = {};
    isa::Taken taken;
    while (taken.words < words.size() && steps_.size() < max_steps) {
        const isa::Instruction in = *isa::decode(words[taken.words]);
        const isa::OpInfo& row = isa::info(in.op);
        const bool may_be_triangle = in.op == isa::Op::set_enabs && !steps_.empty();
        if (row.is_control() || (row.effects & isa::port) != 0 || may_be_triangle) {
            break;
        }
        add_step(words.subspan(taken.words), taken);
    }
    return taken;
}

/// Adds the beginning of `words`, with as many fused instructions as possible, and counts it.
void Stretch::add_step(std::span<const std::uint32_t> words, isa::Taken& taken) {
    const isa::Instruction first = *isa::decode(words[0]);
    const auto coefficients = static_cast<std::size_t>(isa::info(first.op).words);
    std::size_t length = 1 + coefficients;
    Step step{nullptr,
              words.first(length),
              code_.handlers[static_cast<std::size_t>(first.op)],
              first.operands,
              // int32_t and uint32_t may alias.
              {reinterpret_cast<const std::int32_t*>(words.data()) + 1, coefficients}};
    for (const Fused& fused : code_.fused) {
        const std::size_t matched = fused.match(words);
        if (matched > length || (matched == length && step.fused == nullptr)) {
            length = matched;
            step.fused = &fused;
            step.words = words.first(length);
        }
    }
    steps_.push_back(step);
    for (std::size_t at = 0; at < length;) {
        const isa::Instruction in = *isa::decode(words[at]);
        const isa::OpInfo& row = isa::info(in.op);
        note_wake(in);
        at += 1 + static_cast<std::size_t>(row.words);
        taken.instructions += 1;
        taken.cycles += row.cycles(in.operands);
    }
    taken.words += length;
}

void Stretch::note_wake(isa::Instruction in) {
    if ((isa::info(in.op).effects & isa::all) == 0 || in.op == isa::Op::clr_enabs) {
        return;
    }
    if (in.op == isa::Op::mem_into_enab || in.op == isa::Op::enab_or_mem) {
        wake_bits_[in.operands.a / 32] |= std::uint32_t{1} << in.operands.a % 32;
    } else {
        wakes_all_ = true;
    }
}

/// Lists the tiles of a group that the stretch affects. Returns their number.
std::size_t Stretch::find_awake(hal::PixelArray& pixels, std::size_t first_block,
                                Tile* tiles) const {
    std::size_t count = 0;
    for (std::size_t b = first_block; b < first_block + group_blocks; ++b) {
        for (std::size_t t = 0; t < tiles_per_block; ++t) {
            const std::size_t in_block = t * hal::tile_pixels;
            const std::size_t index = b * hal::block_pixels + in_block;
            bool awake = wakes_all_ || (pixels.enable[index / 8] | pixels.enable[index / 8 + 1]);
            for (std::size_t k = 0; k < hal::column_count && !awake; ++k) {
                awake = wake_bits_[k] != 0 &&
                        any_has(&pixels.blocks[b].columns[k][in_block], wake_bits_[k]);
            }
            tiles[count] = {&pixels.blocks[b].columns[0][in_block], index};
            count += awake ? 1 : 0;
        }
    }
    return count;
}

void Stretch::run(hal::Board& board) const {
    for (std::size_t block = 0; block < hal::block_count; block += group_blocks) {
        Tile tiles[group_blocks * tiles_per_block];
        const std::size_t awake = find_awake(board.pixels, block, tiles);
        if (awake == 0) {
            continue;
        }
        for (std::size_t i = 0; i < steps_.size(); ++i) {
            const Step& step = steps_[i];
            if (step.fused == nullptr) {
                step.handler(board, {block, block + group_blocks}, step.operands,
                             step.coefficients);
                continue;
            }
            step.fused->run(board, {tiles, awake}, step.words);
            // Handlers skip blocks without enabled pixels; fused programs do not.
            if (i + 1 == steps_.size() || steps_[i + 1].fused == nullptr) {
                for (std::size_t b = block; b < block + group_blocks; ++b) {
                    board.pixels.note_occupied(b);
                }
            }
        }
    }
}

}  // namespace pxpl5::renderer::fast
