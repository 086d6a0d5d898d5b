// Tests properties of all rows that follow from the table.
#include <doctest/doctest.h>

#include <bit>
#include <memory>

#include "isa/assemble.hpp"
#include "isa/disassemble.hpp"
#include "isa/reference/reference.hpp"
#include "tests/isa/random_program.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
using isa::Instruction;
using isa::Operands;
using isa::OpInfo;

namespace {

constexpr isa::reference::Window window{.x0 = 61, .y0 = 20, .width = 8, .height = 6};
constexpr int samples = 60;

/// Returns the words of a random instruction of `row`, with coefficients.
std::vector<std::uint32_t> instruction(test::RandomPrograms& random, const OpInfo& row) {
    const auto op = static_cast<isa::Op>(&row - isa::op_table.data());
    std::vector<std::uint32_t> words{isa::encode({op, random.operands(row)})};
    for (int i = 0; i < row.words; ++i) {
        words.push_back(static_cast<std::uint32_t>(random.coefficient()));
    }
    return words;
}

isa::Coefficients coefficients(const std::vector<std::uint32_t>& words) {
    return {reinterpret_cast<const std::int32_t*>(words.data() + 1), words.size() - 1};
}

/// A window of noise: memory, enables and carries.
std::unique_ptr<isa::reference::Reference> noisy(test::RandomPrograms& random) {
    auto pixels = std::make_unique<isa::reference::Reference>(window);
    const auto each_bit = [&](std::uint32_t a, std::uint32_t n) {
        for (int i = 0; i < window.width * window.height; ++i) {
            const std::uint64_t bits =
                std::uint64_t{random.below(1U << 30)} << 30 | random.below(1U << 30);
            pixels->set_field(window.x0 + i % window.width, window.y0 + i / window.width, a, n,
                              bits);
        }
    };
    // Adding noise to noise sets the carries; a bit of noise sets the enables.
    pixels->execute({isa::Op::set_enabs, {}}, {});
    each_bit(0, 52), each_bit(52, 52);
    pixels->execute({isa::Op::mem_plus_mem, {0, 52, 52}}, {});
    each_bit(0, 52), each_bit(104, 52), each_bit(156, 52);
    pixels->execute({isa::Op::mem_into_enab, {random.below(isa::memory_bits), 0, 0}}, {});
    return pixels;
}

struct State {
    std::vector<bool> memory;
    bool enable, carry;
    explicit State(const isa::reference::Reference& pixels, int x, int y)
        : enable(pixels.enabled(x, y)), carry(pixels.carry(x, y)) {
        for (std::uint32_t a = 0; a < isa::memory_bits; ++a) {
            memory.push_back(pixels.field(x, y, a, 1) != 0);
        }
    }
};

/// Checks that `row` changed only what it may change in this pixel.
void check_effects(const OpInfo& row, const Operands& o, const State& before, const State& after) {
    const bool acts = before.enable || (row.effects & isa::all) != 0;
    for (std::uint32_t a = 0; a < isa::memory_bits; ++a) {
        const bool may_write =
            acts && (row.effects & isa::mem) != 0 && a >= o.a && a < o.a + row.at_a(o);
        if (!may_write && before.memory[a] != after.memory[a]) {
            FAIL_CHECK(row.name, " changed bit ", a, " of ", before.enable ? "an enabled" : "a dis",
                       " pixel");
        }
    }
    const auto may = [&](isa::Effects effect) { return acts && (row.effects & effect) != 0; };
    CHECK((before.carry == after.carry || may(isa::carry)));
    CHECK((before.enable == after.enable || may(isa::enable)));
    if ((row.effects & isa::all) == 0) {
        CHECK_MESSAGE((before.enable || !after.enable), row.name, " enabled a pixel");
    }
}

}  // namespace

TEST_CASE("a word of any row survives decoding and encoding, assembly and disassembly") {
    const std::uint64_t seed = test::seed_or<std::uint64_t>(11);
    INFO("PXPL5_SEED=", seed);
    test::RandomPrograms random(seed);
    for (const OpInfo& row : isa::op_table) {
        for (int i = 0; i < samples; ++i) {
            const std::vector<std::uint32_t> words = instruction(random, row);
            const auto in = isa::decode(words[0]);
            REQUIRE(in);
            CHECK(isa::encode(*in) == words[0]);
            const std::string text = isa::disassemble(words);
            INFO(text);
            CHECK(isa::assemble(text).words == words);
        }
    }
}

TEST_CASE("a word with a bit set that must be 0 is no instruction") {
    for (const OpInfo& row : isa::op_table) {
        const isa::Pattern& p = row.pattern;
        for (unsigned bit = 0; bit < isa::op_byte_shift; ++bit) {
            if ((p.fixed_mask >> bit & 1) != 0) {
                CHECK_FALSE(isa::decode(p.fixed_bits ^ 1U << bit));
            }
        }
    }
    std::size_t rows = 0;
    for (std::uint32_t byte = 0; byte < 256; ++byte) {
        rows += isa::decode(byte << isa::op_byte_shift).has_value() ? 1 : 0;
    }
    CHECK(rows == isa::op_count);
}

TEST_CASE("an instruction changes nothing but what its row says") {
    const std::uint64_t seed = test::seed_or<std::uint64_t>(12);
    INFO("PXPL5_SEED=", seed);
    test::RandomPrograms random(seed);
    for (const OpInfo& row : isa::op_table) {
        if (row.is_control()) {
            continue;
        }
        for (int i = 0; i < 6; ++i) {
            const std::vector<std::uint32_t> words = instruction(random, row);
            const auto pixels = noisy(random);
            std::vector<State> before;
            for (int y = window.y0; y < window.y0 + window.height; ++y) {
                for (int x = window.x0; x < window.x0 + window.width; ++x) {
                    before.emplace_back(*pixels, x, y);
                }
            }
            const Instruction in = *isa::decode(words[0]);
            INFO(isa::disassemble(words));
            pixels->execute(in, coefficients(words));
            std::size_t k = 0;
            for (int y = window.y0; y < window.y0 + window.height; ++y) {
                for (int x = window.x0; x < window.x0 + window.width; ++x) {
                    check_effects(row, in.operands, before[k++], State(*pixels, x, y));
                }
            }
        }
    }
}

TEST_CASE("every instruction costs something, and a wider one no less") {
    for (const OpInfo& row : isa::op_table) {
        for (const std::uint32_t b : {0U, 7U, 63U}) {
            std::uint32_t last = row.cycles({0, b, row.n_max == 0 ? 0U : 1U});
            CHECK(last > 0);
            for (std::uint32_t n = 2; n <= row.n_max; ++n) {
                const std::uint32_t cycles = row.cycles({0, b, n});
                CHECK_MESSAGE(cycles >= last, row.name);
                last = cycles;
            }
        }
    }
}
