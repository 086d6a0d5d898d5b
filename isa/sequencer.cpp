#include "isa/sequencer.hpp"

#include <fmt/format.h>

#include <array>
#include <cassert>

namespace pxpl5::isa {

void Sequencer::count(std::uint64_t instructions, std::uint64_t cycles) {
    state_.counts.instructions += instructions;
    state_.counts.cycles += cycles;
    const std::uint64_t limit =
        controller_.step_limit ? *controller_.step_limit : usual_step_limit(words_.size());
    if (state_.counts.instructions > limit) {
        throw RunError(fmt::format("word {}: the run executed {} instructions; the limit is {}",
                                   state_.at, state_.counts.instructions, limit));
    }
}

void Sequencer::step() {
    assert(!done());
    const std::optional<Instruction> in = decode(words_[state_.at]);
    assert(in);
    const OpInfo& row = info(in->op);
    count(1, row.cycles(in->operands));
    const auto words = static_cast<std::size_t>(row.words);
    const std::span<const std::uint32_t> coefficients = words_.subspan(state_.at + 1, words);
    state_.at += 1 + words;
    if (row.is_control()) {
        control(*in, coefficients);
    } else {
        executor_.execute(*in, signed_words(coefficients));
    }
}

const RunCounts& Sequencer::run() {
    while (!done()) {
        const Taken taken = executor_.execute_ahead(words_.subspan(state_.at));
        if (taken.words == 0) {
            step();
        } else {
            state_.at += taken.words;
            count(taken.instructions, taken.cycles);
        }
    }
    return state_.counts;
}

void Sequencer::control(Instruction in, std::span<const std::uint32_t> coefficients) {
    switch (in.op) {
        case Op::any_enab:
            controller_.flag = executor_.any_enabled();
            break;
        case Op::bs_wait:
            break;  // Transfers take effect at issue; check() refuses programs that could notice.
        case Op::nop:
            break;
        case Op::eor:
            state_.at = words_.size();
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
            state_.at = controller_.flag ? state_.at : coefficients[0];
            break;
        case Op::signal:
            signal(in.operands.b);
            break;
        default:
            assert(false && "the sequencer does not implement this control row");
    }
}

void Sequencer::signal(std::uint32_t number) {
    if (controller_.on_signal) {
        controller_.on_signal(number);
    }
}

void Sequencer::call(std::size_t target) {
    if (state_.returns.size() == max_call_depth) {
        throw RunError(fmt::format("word {}: CALL at depth {}; the limit is {}", state_.at - 2,
                                   state_.returns.size() + 1, max_call_depth));
    }
    state_.returns.push_back(state_.at);
    state_.at = target;
}

void Sequencer::return_from_call() {
    if (state_.returns.empty()) {
        throw RunError(fmt::format("word {}: RET without a CALL", state_.at - 1));
    }
    state_.at = state_.returns.back();
    state_.returns.pop_back();
}

void Sequencer::open_loop(std::uint32_t rounds) {
    if (rounds == 0) {
        state_.at = behind_matching_end_loop();
        return;
    }
    if (state_.loops.size() == max_loop_depth) {
        throw RunError(fmt::format("word {}: LOOP at depth {}, calls included; the limit is {}",
                                   state_.at - 1, state_.loops.size() + 1, max_loop_depth));
    }
    state_.loops.push_back({state_.at, rounds});
}

void Sequencer::close_loop() {
    assert(!state_.loops.empty());
    if (--state_.loops.back().left != 0) {
        state_.at = state_.loops.back().body;
    } else {
        state_.loops.pop_back();
    }
}

std::size_t Sequencer::behind_matching_end_loop() const {
    std::size_t depth = 1;
    std::size_t at = state_.at;
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
