#include "renderer_firmware/igc/igc.hpp"

#include "isa/triangle_shape.hpp"

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

Outcome Igc::run_checked(std::span<const std::uint32_t> words) {
    Outcome outcome;
    isa::Sequencer sequencer(words, executor_, controller_);
    try {
        sequencer.run();
    } catch (const isa::RunError& error) {
        outcome.error = isa::ProgramError{sequencer.at(), error.what()};
    }
    outcome.counts = sequencer.counts();
    return outcome;
}

Outcome Igc::run(std::span<const std::uint32_t> words) {
    if (const std::optional<isa::ProgramError> error = check(words)) {
        return {{}, error};
    }
    return run_checked(words);
}

}  // namespace pxpl5::renderer
