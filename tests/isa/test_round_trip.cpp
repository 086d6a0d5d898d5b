// Tests asm(dis(x)) = x for every word that is an instruction.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>

#include "isa/assemble.hpp"
#include "isa/disassemble.hpp"
#include "isa/executor.hpp"

using namespace pxpl5;
using isa::Op;
using isa::Operands;
using isa::OpInfo;

namespace {

constexpr std::size_t words_at_once = 1 << 14;
constexpr std::uint32_t operand_values = 256;

/// Collects instructions and checks in batches that they survive disassembly and assembly.
class RoundTrip {
  public:
    RoundTrip() { words_.reserve(words_at_once + 7); }
    RoundTrip(const RoundTrip&) = delete;
    RoundTrip& operator=(const RoundTrip&) = delete;
    ~RoundTrip() { flush(); }

    void add(std::uint32_t word, const OpInfo& row, const std::array<std::int32_t, 6>& k) {
        words_.push_back(word);
        for (int i = 0; i < row.words; ++i) {
            words_.push_back(static_cast<std::uint32_t>(k[static_cast<std::size_t>(i)]));
        }
        ++instructions_;
        if (words_.size() >= words_at_once) {
            flush();
        }
    }
    void flush() {
        const std::vector<std::uint32_t> back = isa::assemble(isa::disassemble(words_)).words;
        if (back != words_) {
            const auto [found, want] = std::ranges::mismatch(back, words_);
            FAIL_CHECK("word ", want == words_.end() ? 0 : *want, " became ",
                       found == back.end() ? 0 : *found, " or its coefficients did");
        }
        words_.clear();
    }
    std::size_t instructions() const { return instructions_; }

  private:
    std::vector<std::uint32_t> words_;
    std::size_t instructions_ = 0;
};

/// True if check() accepts the word, with coefficients behind it and BSWAIT after a transfer. Rules
/// about jumps and loops do not matter.
bool is_encodable(const OpInfo& row, const Operands& o) {
    const bool fields_fit = row.at_a(o) + o.a <= isa::memory_bits || row.at_a(o) == 0;
    const bool b_fits = row.b_role == isa::Role::address
                            ? o.b + row.at_b(o) <= isa::memory_bits
                            : (row.b_role != isa::Role::fraction || o.b <= 63) &&
                                  (row.b_role != isa::Role::block || o.b < isa::backing_blocks);
    return fields_fit && b_fits && (row.n_max == 0 || (o.n >= 1 && o.n <= row.n_max));
}

/// Returns the values that fit an operand field; only 0 if there is no field.
std::uint32_t values_of(isa::OperandField field) {
    return field.mask == 0 ? 1 : operand_values;
}

/// Calls action(word) for every encodable word.
template <typename Action>
void each_word(const OpInfo& row, const Action& action) {
    const auto op = static_cast<Op>(&row - isa::op_table.data());
    Operands o;
    for (o.n = 0; o.n < values_of(row.pattern.n); ++o.n) {
        for (o.b = 0; o.b < values_of(row.pattern.b); ++o.b) {
            for (o.a = 0; o.a < values_of(row.pattern.a); ++o.a) {
                if (is_encodable(row, o)) {
                    action(isa::encode({op, o}));
                }
            }
        }
    }
}

}  // namespace

TEST_CASE("every encodable word survives disassembly and assembly") {
    RoundTrip trip;
    std::size_t rows = 0;
    for (const OpInfo& row : isa::op_table) {
        const std::size_t before = trip.instructions();
        each_word(row, [&](std::uint32_t word) {
            // Each word has other coefficients, so that exchanged coefficients show.
            const auto k = static_cast<std::int32_t>(word * 2654435761U);
            trip.add(word, row, {k, ~k, k >> 8, -k / 3, 0, k ^ 0x5555});
        });
        CHECK(trip.instructions() > before);
        ++rows;
    }
    trip.flush();
    CHECK(rows == isa::op_count);
    MESSAGE(trip.instructions(), " words");
}

TEST_CASE("extreme coefficients survive disassembly and assembly, in every place") {
    constexpr std::int32_t extremes[] = {INT32_MIN, INT32_MIN + 1, -1, 0, 1, INT32_MAX};
    RoundTrip trip;
    for (std::size_t i = 0; i < isa::op_count; ++i) {
        const OpInfo& row = isa::op_table[i];
        const Operands o{0, 0, row.n_max == 0 ? 0U : 1U};
        for (std::size_t place = 0; place < static_cast<std::size_t>(row.words); ++place) {
            for (const std::int32_t one : extremes) {
                for (const std::int32_t others : extremes) {
                    std::array<std::int32_t, 6> k{};
                    k.fill(others);
                    k.at(place) = one;
                    trip.add(isa::encode({static_cast<Op>(i), o}), row, k);
                }
            }
        }
    }
    trip.flush();
    CHECK(trip.instructions() > 2900);
}
