// Assembly: a text that assembles gives words whose disassembly assembles to the same words.
#include "isa/assemble.hpp"

#include <fmt/format.h>

#include "isa/conformance/conformance_file.hpp"
#include "isa/disassemble.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace pxpl5::fuzz {

namespace {

/// The words without a line for each that does not decode, which disassembles to a comment.
bool decodes(std::span<const std::uint32_t> words) {
    for (std::size_t at = 0; at < words.size();) {
        if (!isa::decode(words[at])) {
            return false;
        }
        at += isa::instruction_words(words[at]);
        if (at > words.size()) {
            return false;
        }
    }
    return true;
}

void check_round_trip(const std::vector<std::uint32_t>& words) {
    const std::string text = isa::disassemble(words);
    require(isa::assemble(text).words == words, "another stream comes from: " + text);
    isa::disassemble(words, {true});
}

/// The place that an error names lies in the text, or just behind it.
template <typename Error>
void check_place(const Error& error, const std::string& text) {
    const auto lines = static_cast<std::size_t>(std::ranges::count(text, '\n')) + 1;
    require(error.line >= 1 && error.line <= lines && error.column >= 1 &&
                error.column <= text.size() + 1,
            fmt::format("line {}, column {} of {} lines: {}", error.line, error.column, lines,
                        error.what()));
    require(std::string(error.what()).find(fmt::format("line {}", error.line)) == 0, error.what());
}

void check_program(const isa::Program& program) {
    for (const auto& [name, word] : program.labels) {
        require(word <= program.words.size(), "the place of label " + name);
    }
    isa::Parameters zeros, ones;
    for (const isa::Program::Patch& patch : program.patches) {
        require(patch.word < program.words.size(), "the place of parameter " + patch.name);
        zeros[patch.name] = 0;
        ones[patch.name] = UINT8_MAX;
    }
    require(program.bind(zeros) == program.words, "parameters of 0 change words");
    check_round_trip(program.words);
    check_round_trip(program.bind(ones));
}

bool accepts_text(const std::string& text) {
    try {
        check_program(isa::assemble(text));
        return true;
    } catch (const isa::AssemblyError& error) {
        check_place(error, text);
        return false;
    }
}

bool accepts_case(const std::string& text) {
    try {
        const isa::ConformanceCase test = isa::parse_conformance(text);
        require(isa::check(test.program.words).ok(), "the program of a conformance case");
        return true;
    } catch (const isa::ConformanceError& error) {
        check_place(error, text);
        return false;
    }
}

bool accepts_words(Bytes bytes) {
    std::vector<std::uint32_t> words;
    while (!bytes.empty()) {
        words.push_back(bytes.take<std::uint32_t>());
    }
    isa::disassemble(words, {true});
    const std::string text = isa::disassemble(words);
    if (!isa::check(words).ok()) {
        require(!decodes(words) || !text.empty() || words.empty(), "an empty disassembly");
        return false;
    }
    check_round_trip(words);
    return true;
}

}  // namespace

/// Input: 'a' and assembly, 'c' and a conformance case, or another byte and words.
bool accepts(Input input) {
    Bytes bytes(input);
    switch (bytes.take<char>()) {
        case 'a':
            return accepts_text(bytes.text());
        case 'c':
            return accepts_case(bytes.text());
        default:
            return accepts_words(bytes);
    }
}

}  // namespace pxpl5::fuzz
