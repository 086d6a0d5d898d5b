#include "isa/instruction_counts.hpp"

#include <doctest/doctest.h>

#include <vector>

#include "isa/assemble.hpp"
#include "isa/contract/region_layout.hpp"
#include "isa/contract/triangle_shape.hpp"
#include "isa/reference/reference.hpp"
#include "isa/sequencer.hpp"

using namespace pxpl5::isa;

namespace {

using Words = std::vector<std::uint32_t>;

Words assembled(std::string_view text) {
    return assemble(text).bind({});
}

const ClassCounts& of(const InstructionCounts& counts, InstructionClass which) {
    return counts.classes[static_cast<std::size_t>(which)];
}

}  // namespace

TEST_CASE("an instruction's class is the section of the table that its row stands in") {
    CHECK(class_of(Op::set_enabs) == InstructionClass::enable);
    CHECK(class_of(Op::any_enab) == InstructionClass::enable);
    CHECK(class_of(Op::tree_ge_zero) == InstructionClass::tree);
    CHECK(class_of(Op::mem_minus_quad) == InstructionClass::tree);
    CHECK(class_of(Op::mem_into_mem) == InstructionClass::memory);
    CHECK(class_of(Op::sqrt_mem) == InstructionClass::arithmetic);
    CHECK(class_of(Op::bs_wait) == InstructionClass::backing);
    CHECK(class_of(Op::pixels_to_fb) == InstructionClass::control);
    CHECK(name_of(class_of(Op::bs_read)) == "backing");
}

TEST_CASE("a text's counts are those of its rows, each once") {
    // Cycles: 1, n + 1, 40, 16000 (a wait), 16384 + n (the port), 4.
    const InstructionCounts counts = count_text(assembled(R"(
        SETENABS
        CLEARMEM m0:20
        BSWRITE m0 bs3
        BSWAIT
        PIXELSTOFB m0:32
        EOR
    )"));
    CHECK(of(counts, InstructionClass::enable) == ClassCounts{1, 1});
    CHECK(of(counts, InstructionClass::tree) == ClassCounts{});
    CHECK(of(counts, InstructionClass::memory) == ClassCounts{1, 21});
    CHECK(of(counts, InstructionClass::arithmetic) == ClassCounts{});
    CHECK(of(counts, InstructionClass::backing) == ClassCounts{2, 16040});
    CHECK(of(counts, InstructionClass::control) == ClassCounts{2, 16420});
    CHECK(counts.backing_cycles == 16000);
    CHECK(counts.port_cycles == 16416);
    CHECK(counts.total() == ClassCounts{6, 32482});
}

TEST_CASE("k triangles count k times what one does") {
    Words one(triangle::word_count);
    one[triangle::at_enable] = triangle::enable_word;
    for (const std::size_t at : triangle::at_edge) {
        one[at] = triangle::edge_word(24);
    }
    one[triangle::at_z_test] = triangle::z_test_word;
    one[triangle::at_z_store] = triangle::z_store_word;
    for (std::size_t k = 0; k < 3; ++k) {
        one[triangle::at_normal[k]] = triangle::normal_words[k];
    }
    one[triangle::at_surface] = triangle::surface_word(1);
    REQUIRE(triangle::matches(one.data()));
    // A tree row takes n + 4 cycles, plus b for dropped fraction bits.
    const std::uint64_t tree_cycles =
        3 * (24 + 4) + 2 * (region::z_fraction_bits + region::z.width + 4) +
        3 * (region::normal_fraction_bits + region::normal_x.width + 4);
    Words all;
    for (std::uint64_t k = 1; k <= 7; ++k) {
        all.insert(all.end(), one.begin(), one.end());
        const InstructionCounts counts = count_text(all);
        CHECK(of(counts, InstructionClass::enable) == ClassCounts{k, k});
        CHECK(of(counts, InstructionClass::tree) == ClassCounts{8 * k, tree_cycles * k});
        CHECK(of(counts, InstructionClass::memory) ==
              ClassCounts{k, (region::surface.width + 1) * k});
        CHECK(counts.total().instructions == 10 * k);
        CHECK(counts.port_cycles + counts.backing_cycles == 0);
    }
    CHECK(runs_straight(all));
}

TEST_CASE("a program runs straight unless a row of it may turn elsewhere") {
    CHECK(runs_straight({}));
    CHECK(runs_straight(assembled("SETENABS\nBSWRITE m0 bs3\nBSWAIT\nANYENAB\nSIGNAL #3\nEOR")));
    CHECK_FALSE(runs_straight(assembled("SETENABS\nEOR\nCLRENABS")));
    CHECK_FALSE(runs_straight(assembled("LOOP #2\nINVENABS\nENDLOOP")));
    CHECK_FALSE(runs_straight(assembled("ANYENAB\nSKIPIFNONE end\nINVENABS\nend:\nNOP")));
}

TEST_CASE("what runs straight executes what its text counts") {
    const Words words = assembled("SETENABS\nCLEARMEM m0:20\nBSWRITE m0 bs3\nBSWAIT\nEOR");
    reference::Reference reference({0, 0, 1, 1});
    Controller controller;
    const RunCounts ran = run(words, reference, controller);
    CHECK(ran.instructions == count_text(words).total().instructions);
    CHECK(ran.cycles == count_text(words).total().cycles);
}
