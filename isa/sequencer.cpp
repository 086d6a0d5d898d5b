#include "isa/sequencer.hpp"

#include <fmt/format.h>

#include <array>
#include <cassert>

namespace pxpl5::isa {
namespace {

/// Coefficients as signed words. At most 6 follow an instruction.
Coefficients signed_words(std::span<const std::uint32_t> words) {
    // int32_t is the signed type of uint32_t, so that reading one as the other is defined.
    return {reinterpret_cast<const std::int32_t*>(words.data()), words.size()};
}

}  // namespace

void Sequencer::count(std::uint64_t instructions, std::uint64_t cycles) {
    counts_.instructions += instructions;
    counts_.cycles += cycles;
    if (counts_.instructions > controller_.step_limit) {
        throw RunError(fmt::format("word {}: stopped after {} instructions; the limit is {}", at_,
                                   counts_.instructions, controller_.step_limit));
    }
}

void Sequencer::step() {
    assert(!done());
    const std::optional<Instruction> in = decode(words_[at_]);
    assert(in);
    const OpInfo& row = info(in->op);
    count(1, row.cycles(in->operands));
    const auto words = static_cast<std::size_t>(row.words);
    const std::span<const std::uint32_t> coefficients = words_.subspan(at_ + 1, words);
    at_ += 1 + words;
    if (row.is_control()) {
        control(*in, coefficients);
    } else {
        executor_.execute(*in, signed_words(coefficients));
    }
}

const RunCounts& Sequencer::run() {
    while (!done()) {
        const Taken taken = executor_.execute_ahead(words_.subspan(at_));
        if (taken.words == 0) {
            step();
        } else {
            at_ += taken.words;
            count(taken.instructions, taken.cycles);
        }
    }
    return counts_;
}

void Sequencer::control(Instruction in, std::span<const std::uint32_t> coefficients) {
    switch (in.op) {
        case Op::any_enab:
            controller_.flag = executor_.any_enabled();
            break;
        case Op::bs_wait:
            break;  // Transfers take effect at issue; check() keeps programs off them.
        case Op::nop:
            break;
        case Op::eor:
            at_ = words_.size();
            break;
        case Op::call:
            call(coefficients[0]);
            break;
        case Op::ret:
            return_from_call();
            break;
        case Op::loop:
            open_loop(in.operands.b);
            break;
        case Op::end_loop:
            close_loop();
            break;
        case Op::skip_if_none:
            at_ = controller_.flag ? at_ : coefficients[0];
            break;
        case Op::signal:
            signal(in.operands.b);
            break;
        default:
            assert(false && "a control row that the sequencer does not know");
    }
}

void Sequencer::signal(std::uint32_t number) {
    if (controller_.on_signal) {
        controller_.on_signal(number);
    }
}

void Sequencer::call(std::size_t target) {
    if (returns_.size() == max_call_depth) {
        throw RunError(fmt::format("word {}: CALL at depth {}; the limit is {}", at_ - 2,
                                   returns_.size() + 1, max_call_depth));
    }
    returns_.push_back(at_);
    at_ = target;
}

void Sequencer::return_from_call() {
    if (returns_.empty()) {
        throw RunError(fmt::format("word {}: RET without a CALL", at_ - 1));
    }
    at_ = returns_.back();
    returns_.pop_back();
}

void Sequencer::open_loop(std::uint32_t rounds) {
    if (rounds == 0) {
        at_ = behind_matching_end_loop();
        return;
    }
    if (loops_.size() == max_loop_depth) {
        throw RunError(fmt::format("word {}: LOOP at depth {}, calls included; the limit is {}",
                                   at_ - 1, loops_.size() + 1, max_loop_depth));
    }
    loops_.push_back({at_, rounds});
}

void Sequencer::close_loop() {
    assert(!loops_.empty());
    if (--loops_.back().left != 0) {
        at_ = loops_.back().body;
    } else {
        loops_.pop_back();
    }
}

std::size_t Sequencer::behind_matching_end_loop() const {
    std::size_t depth = 1;
    std::size_t at = at_;
    while (depth != 0) {
        assert(at < words_.size());
        const Op op = decode(words_[at])->op;
        depth += op == Op::loop ? 1 : 0;
        depth -= op == Op::end_loop ? 1 : 0;
        at += instruction_words(words_[at]);
    }
    return at;
}

RunCounts run(std::span<const std::uint32_t> words, Executor& executor, Controller& controller) {
    return Sequencer(words, executor, controller).run();
}

}  // namespace pxpl5::isa
