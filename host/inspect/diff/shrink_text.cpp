// A shrunk program as files: assembly, a doctest case, a conformance case.
#include <fmt/format.h>

#include "host/inspect/diff/shrink.hpp"
#include "isa/reference/reference.hpp"
#include "isa/sequencer.hpp"

namespace pxpl5::host::inspect {

namespace {

/// The lines of the program, each behind `indent`.
std::string listing(const Shrunk& shrunk, std::string_view indent) {
    std::string text;
    const std::span<const std::uint32_t> words(shrunk.words);
    for (std::size_t at = 0; at < words.size();) {
        text += fmt::format("{}{}\n", indent, instruction_text(words, at));
        at += isa::instruction_words(words[at]);
    }
    return text;
}

/// The header that a test case needs. The host writes its name but does not include it.
std::string test_headers() {
    std::string text;
    for (const char* header : {"tests/isa/lockstep.hpp", "tests/renderer_firmware/targets.hpp"}) {
        text += fmt::format("#{} \"{}\"\n", "include", header);
    }
    return text;
}

}  // namespace

std::string as_assembly(const Shrunk& shrunk, const ShrunkStory& story) {
    return fmt::format("; {}\n; {}\n; pixel ({}, {}) of the region; {} instructions of {}\n{}",
                       story.title, story.from, story.pixel.x, story.pixel.y, shrunk.instructions,
                       shrunk.instructions_before, listing(shrunk, "    "));
}

std::string as_doctest(const Shrunk& shrunk, const ShrunkStory& story) {
    return fmt::format(
        R"x(// Made by pxpl5 trace shrink: {} instructions of {}.
// {}
#include <doctest/doctest.h>

#include "isa/assemble.hpp"
#include "isa/sequencer.hpp"
{}
TEST_CASE("{}") {{
    using namespace pxpl5;
    const std::vector<std::uint32_t> words = isa::assemble(R"(
{})")
                                                 .bind({{}});
    test::on_every_target([&](renderer::fast::Fast& fast) {{
        isa::reference::Reference reference;
        test::Lockstep both(reference, fast);
        isa::Controller trusted, tested;
        isa::run(words, reference, trusted);
        isa::run(words, fast, tested);
        CHECK_NOTHROW(both.compare_all("at the end"));
    }});
}}
)x",
        shrunk.instructions, shrunk.instructions_before, story.from, test_headers(), story.title,
        listing(shrunk, "        "));
}

std::string as_conformance(const Shrunk& shrunk, const ShrunkStory& story) {
    isa::reference::Reference reference;
    isa::Controller controller;
    isa::run(shrunk.words, reference, controller);
    const auto [x, y] = story.pixel;
    std::string text = fmt::format(
        "; {}\ntitle  {}\nwatch  {},{}\n{}run\n{}expect m0:52 m52:52 "
        "m104:52 m156:52 enable carry\n  {},{}",
        story.from, story.title, x, y, controller.flag ? "" : "flag   0\n", listing(shrunk, "  "),
        x, y);
    for (std::uint32_t a = 0; a < isa::memory_bits; a += 52) {
        text += fmt::format(" 0x{:x}", reference.field(x, y, a, 52));
    }
    return text +
           fmt::format(" {} {}\n", reference.enabled(x, y) ? 1 : 0, reference.carry(x, y) ? 1 : 0);
}

}  // namespace pxpl5::host::inspect
