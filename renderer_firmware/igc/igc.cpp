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

Outcome Igc::run(std::span<const std::uint32_t> words) {
    Outcome outcome;
    if (!only_triangles(words)) {
        outcome.error = isa::check(words).error;
        if (outcome.error) {
            return outcome;
        }
    }
    isa::Sequencer sequencer(words, executor_, controller_);
    try {
        sequencer.run();
    } catch (const isa::RunError& error) {
        outcome.error = isa::ProgramError{sequencer.at(), error.what()};
    }
    outcome.counts = sequencer.counts();
    return outcome;
}

}  // namespace pxpl5::renderer
