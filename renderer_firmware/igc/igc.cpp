#include "renderer_firmware/igc/igc.hpp"

#include "isa/contract/triangle_shape.hpp"

namespace pxpl5::renderer {

bool only_triangles(std::span<const std::uint32_t> words) {
    if (words.size() % isa::triangle::word_count != 0) {
        return false;
    }
    for (std::size_t at = 0; at < words.size(); at += isa::triangle::word_count) {
        if (!isa::triangle::matches(words.data() + at)) {
            return false;
        }
    }
    return true;
}

std::optional<isa::ProgramError> Igc::check(std::span<const std::uint32_t> words) {
    return only_triangles(words) ? std::nullopt : isa::check(words).error;
}

template <typename Run>
Outcome Igc::run_to_end(std::span<const std::uint32_t> words, const Run& run) {
    Outcome outcome;
    isa::Sequencer sequencer(words, executor_, controller_);
    try {
        run(sequencer);
    } catch (const isa::RunError& error) {
        outcome.error = isa::ProgramError{sequencer.at(), error.what()};
    }
    outcome.counts = sequencer.counts();
    return outcome;
}

Outcome Igc::run_checked(std::span<const std::uint32_t> words) {
    return run_to_end(words, [](isa::Sequencer& sequencer) { sequencer.run(); });
}

Outcome Igc::run_counted(std::span<const std::uint32_t> words, isa::InstructionCounts& executed) {
    if (isa::runs_straight(words)) {
        executed += isa::count_text(words);
        return run_checked(words);
    }
    return run_to_end(words, [&](isa::Sequencer& sequencer) {
        while (!sequencer.done()) {
            executed.add(*isa::decode(words[sequencer.at()]));
            sequencer.step();
        }
    });
}

Outcome Igc::run(std::span<const std::uint32_t> words) {
    if (const std::optional<isa::ProgramError> error = check(words)) {
        return {{}, error};
    }
    return run_checked(words);
}

}  // namespace pxpl5::renderer
