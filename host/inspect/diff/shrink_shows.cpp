// Outputs of a shrunk program.
#include <algorithm>

#include "host/inspect/diff/shrink.hpp"
#include "isa/reference/reference.hpp"
#include "isa/sequencer.hpp"

namespace pxpl5::host::inspect {

namespace {

/// True if what one pixel does can depend on another: through the OR of the enables.
bool pixels_meet(std::span<const std::uint32_t> words) {
    for (std::size_t at = 0; at < words.size(); at += isa::instruction_words(words[at])) {
        if (isa::decode(words[at])->op == isa::Op::skip_if_none) {
            return true;
        }
    }
    return false;
}

/// An executor that is right at `pixel`: one that emulates nothing else, if that is enough.
std::unique_ptr<isa::Executor> executor_at(RegionPixel pixel, const NamedExecutor& executor,
                                           std::span<const std::uint32_t> words) {
    if (executor.is_reference && !pixels_meet(words)) {
        return std::make_unique<isa::reference::Reference>(
            isa::reference::Window{pixel.x, pixel.y, 1, 1});
    }
    return executor.make();
}

/// Instructions that a shrunk program may take; a LOOP in a LOOP could otherwise take for ever.
constexpr std::uint64_t step_limit = 10'000'000;

void run(std::span<const std::uint32_t> words, isa::Executor& executor) {
    isa::Controller controller;
    controller.step_limit = step_limit;
    try {
        isa::run(words, executor, controller);
    } catch (const isa::RunError&) {
        // What ran has run, as on a Renderer.
    }
}

}  // namespace

Shows differ_at(RegionPixel pixel, const NamedExecutor& trusted, const NamedExecutor& other) {
    return [=](std::span<const std::uint32_t> words) {
        const auto first = executor_at(pixel, trusted, words);
        const auto second = executor_at(pixel, other, words);
        const ExecutorPair pair(*first, *second);
        run(words, *first);
        run(words, *second);
        return pair.pixel_difference(pixel.x, pixel.y, blocks_of(words)).has_value();
    };
}

Shows holds_at(RegionPixel pixel, const FieldValue64& field, const NamedExecutor& executor) {
    return [=](std::span<const std::uint32_t> words) {
        const auto one = executor_at(pixel, executor, words);
        run(words, *one);
        return one->field(pixel.x, pixel.y, field.a, field.n) == field.value;
    };
}

}  // namespace pxpl5::host::inspect
