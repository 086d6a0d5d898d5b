#include "tests/isa/random_program.hpp"

#include <algorithm>
#include <cassert>

namespace pxpl5::test {

using isa::Instruction;
using isa::Op;
using isa::Operands;
using isa::OpInfo;

namespace {

constexpr std::size_t recent_count = 6;
constexpr std::uint32_t interesting_widths[] = {1, 2, 8, 10, 16, 24, 31, 32, 33, 48, 63, 64};

bool is_flow_row(Op op) {
    return op == Op::call || op == Op::ret || op == Op::loop || op == Op::end_loop ||
           op == Op::skip_if_none || op == Op::eor;
}

}  // namespace

std::int32_t RandomPrograms::coefficient() {
    const auto any = static_cast<std::int32_t>(static_cast<std::uint32_t>(random_()));
    switch (below(8)) {
        case 0:
            return 0;
        case 1:
            return below(2) == 0 ? INT32_MIN : INT32_MAX;
        case 2:
            return any;
        case 3:
            return any >> 16;
        default:
            return any >> (20 + below(10));
    }
}

/// Returns coefficients of a plane that is zero somewhere in the region, so that tests split the
/// pixels. Sometimes returns coefficients of any size.
void RandomPrograms::tree_coefficients(int count) {
    if (below(4) == 0) {
        for (int i = 0; i < count; ++i) {
            words_.push_back(static_cast<std::uint32_t>(coefficient()));
        }
        return;
    }
    const std::int64_t scale = std::int64_t{1} << below(22);
    const auto slope = [&] { return (static_cast<std::int64_t>(below(65)) - 32) * scale / 16; };
    std::int64_t k[6] = {slope(), slope(), 0, slope() / 64, slope() / 64, slope() / 64};
    const std::int64_t x = below(128), y = below(128);
    k[2] = -(k[0] * x + k[1] * y);
    k[2] -= count == 6 ? k[3] * x * x + k[4] * x * y + k[5] * y * y : 0;
    for (int i = 0; i < count; ++i) {
        words_.push_back(static_cast<std::uint32_t>(k[i]));
    }
}

Operands RandomPrograms::operands(const OpInfo& row) {
    Operands o;
    if (row.n_max != 0) {
        const std::uint32_t wish = below(2) == 0
                                       ? interesting_widths[below(std::size(interesting_widths))]
                                       : 1 + below(row.n_max);
        o.n = std::clamp<std::uint32_t>(wish, 1, row.n_max);
    }
    const auto address = [&](std::uint32_t bits) {
        const std::uint32_t last = isa::memory_bits - bits;
        std::uint32_t at = below(last + 1);
        if (!recent_.empty() && below(3) != 0) {
            at = recent_[below(static_cast<std::uint32_t>(recent_.size()))];
            at += below(2) == 0 ? 0 : below(9) - std::min(at, 4U);
        } else if (below(3) == 0) {
            at = below(7) * 32;
        }
        return std::min(at, last);
    };
    if (row.pattern.a.mask != 0) {
        o.a = address(row.at_a(o));
    }
    switch (row.b_role) {
        case isa::Role::address:
            o.b = address(row.at_b(o));
            break;
        case isa::Role::fraction:
            o.b = below(2) == 0 ? below(64) : below(3) * 8;
            break;
        case isa::Role::block:
            o.b = below(4) == 0 ? below(isa::backing_blocks) : below(3);
            break;
        case isa::Role::number:
            o.b = below(256);
            break;
        case isa::Role::absent:
            break;
    }
    return o;
}

void RandomPrograms::wait() {
    emit({Op::bs_wait, {}});
    open_.clear();
}

void RandomPrograms::wait_if_touched(Instruction in) {
    const OpInfo& row = info(in.op);
    const Operands& o = in.operands;
    const bool touched = std::ranges::any_of(open_, [&](const Transfer& t) {
        const auto hits = [&](std::uint32_t at, std::uint32_t bits) {
            return bits != 0 && at < t.field + isa::backing_block_bits && t.field < at + bits;
        };
        return hits(o.a, row.at_a(o)) || hits(o.b, row.at_b(o)) ||
               (row.b_role == isa::Role::block && o.b == t.block);
    });
    if (touched) {
        wait();
    }
    if (row.b_role == isa::Role::block) {
        open_.push_back({o.a, o.b});
    }
}

void RandomPrograms::emit(Instruction in) {
    words_.push_back(encode(in));
    ++instructions_;
}

Op RandomPrograms::row() {
    return static_cast<Op>(below(isa::op_count));
}

/// Fills 64 bits with values like noise, so that adjacent pixels have different bits.
void RandomPrograms::noise() {
    const Op op = below(2) == 0 ? Op::quad_into_mem : Op::mem_plus_quad;
    const Instruction in{op, {below(isa::memory_bits - 63), below(12), 64}};
    wait_if_touched(in);
    emit(in);
    for (int i = 0; i < 6; ++i) {
        words_.push_back(static_cast<std::uint32_t>(random_()));
    }
}

/// Tests only clear enables. Without this instruction a program would soon run on no pixel.
void RandomPrograms::restore_enables() {
    const Op ways[] = {Op::set_enabs, Op::inv_enabs, Op::mem_into_enab, Op::enab_or_mem};
    const Op op = ways[below(std::size(ways))];
    const Operands o = operands(info(op));
    wait_if_touched({op, o});
    emit({op, o});
}

void RandomPrograms::pixel_instruction(const RandomProgramOptions& options) {
    const Op op = row();
    if (is_flow_row(op)) {
        return options.flow ? emit_flow(op) : void();
    }
    const OpInfo& r = info(op);
    const Operands o = operands(r);
    if (op == Op::pixels_to_fb && below(4) != 0) {
        return;  // This row costs as much as all others together.
    }
    if (op == Op::bs_wait) {
        return wait();
    }
    wait_if_touched({op, o});
    emit({op, o});
    if (r.words > 1) {
        tree_coefficients(r.words);
    } else if (r.words == 1) {
        words_.push_back(static_cast<std::uint32_t>(coefficient()));
    }
    if (r.pattern.a.mask != 0) {
        recent_.push_back(o.a);
        if (recent_.size() > recent_count) {
            recent_.erase(recent_.begin());
        }
    }
}

void RandomPrograms::emit_flow(Op op) {
    if (!open_.empty()) {
        wait();
    }
    if (op == Op::loop && loops_.size() < 2 && skip_at_ == 0) {
        emit({Op::loop, {0, below(4), 0}});
        loops_.push_back(instructions_);
    } else if (op == Op::end_loop && !loops_.empty() && skip_at_ == 0) {
        emit({Op::end_loop, {}});
        loops_.pop_back();
    } else if (op == Op::skip_if_none && skip_at_ == 0) {
        emit({Op::any_enab, {}});
        emit({Op::skip_if_none, {}});
        skip_at_ = words_.size();
        skip_until_ = instructions_ + 1 + below(6);
        words_.push_back(0);
    } else if (op == Op::call && calls_.size() < 3) {
        emit({Op::call, {}});
        calls_.push_back(words_.size());
        words_.push_back(0);
    }
}

/// Closes open loops, ends the program, and adds the subroutine of the CALLs.
void RandomPrograms::finish() {
    if (!open_.empty()) {
        wait();
    }
    if (skip_at_ != 0) {
        words_[skip_at_] = static_cast<std::uint32_t>(words_.size());
        skip_at_ = 0;
    }
    for (; !loops_.empty(); loops_.pop_back()) {
        emit({Op::end_loop, {}});
    }
    if (calls_.empty()) {
        return;
    }
    emit({Op::eor, {}});
    for (const std::size_t call : calls_) {
        words_[call] = static_cast<std::uint32_t>(words_.size());
    }
    for (int i = 0; i < 4; ++i) {
        restore_enables();
        pixel_instruction({.flow = false});
    }
    if (!open_.empty()) {
        wait();
    }
    emit({Op::ret, {}});
}

std::vector<std::uint32_t> RandomPrograms::program(const RandomProgramOptions& options) {
    words_.clear();
    instructions_ = 0;
    calls_.clear();
    recent_.clear();
    emit({Op::set_enabs, {}});
    for (int i = 0; i < 4; ++i) {
        noise();
    }
    while (instructions_ < options.instructions) {
        const bool loop_due =
            !loops_.empty() && skip_at_ == 0 && instructions_ > loops_.back() + 12;
        if (skip_at_ != 0 && instructions_ >= skip_until_) {
            words_[skip_at_] = static_cast<std::uint32_t>(words_.size());
            skip_at_ = 0;
        } else if (loop_due) {
            emit_flow(Op::end_loop);
        } else if (below(5) == 0) {
            restore_enables();
        } else if (below(25) == 0) {
            noise();
        } else {
            pixel_instruction(options);
        }
    }
    finish();
    assert(isa::check(words_).ok());
    return words_;
}

}  // namespace pxpl5::test
