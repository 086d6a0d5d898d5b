// Compares the rows of memory, arithmetic, tree and backing with plain 64-bit arithmetic.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "isa/reference/reference.hpp"
#include "tests/isa/random_program.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
using isa::Op;
using isa::Operands;

namespace {

using u64 = std::uint64_t;
using s64 = std::int64_t;

u64 mask(std::uint32_t n) {
    return n >= 64 ? ~u64{0} : (u64{1} << n) - 1;
}
s64 sign_extended(u64 value, std::uint32_t n) {
    return static_cast<s64>(value << (64 - n)) >> (64 - n);
}

/// The effect of an instruction on one pixel.
struct Outcome {
    std::optional<u64> value;    ///< New m[a], if the row writes.
    std::optional<bool> enable;  ///< Set if the row tests.
    std::optional<bool> carry;
};

Outcome tests(bool kept) {
    return {std::nullopt, kept, std::nullopt};
}
Outcome writes(u64 value) {
    return {value, std::nullopt, std::nullopt};
}
Outcome writes(u64 value, bool carry) {
    return {value, std::nullopt, carry};
}

u64 isqrt(u64 value) {
    u64 root = static_cast<u64>(std::sqrt(static_cast<double>(value)));
    while (root * root > value) {
        --root;
    }
    while ((root + 1) * (root + 1) <= value) {
        ++root;
    }
    return root;
}

/// The definition of the rows in 64-bit integers. `p` is m[a] in n bits, `q` is m[b], `k` is K in n
/// bits.
Outcome expected(Op op, std::uint32_t n, u64 p, u64 q, u64 k, std::uint32_t b) {
    const u64 m = mask(n);
    const s64 sp = sign_extended(p, n), sq = sign_extended(q, n), sk = sign_extended(k, n);
    const u64 sum = (p + q) & m, ksum = (p + k) & m;
    const bool overflow = n == 64 ? sum < p : p + q > m;
    switch (op) {
        case Op::mem_into_mem:
            return writes(q);
        case Op::const_into_mem:
            return writes(k);
        case Op::imm_into_mem:
            return writes(b & m);
        case Op::clear_mem:
            return writes(0);
        case Op::not_mem:
            return writes(~p & m);
        case Op::mem_and_mem:
            return writes(p & q);
        case Op::mem_or_mem:
            return writes(p | q);
        case Op::mem_xor_mem:
            return writes(p ^ q);
        case Op::mem_lt_mem:
            return tests(p < q);
        case Op::mem_lt_mem_s:
            return tests(sp < sq);
        case Op::mem_eq_mem:
            return tests(p == q);
        case Op::mem_eq_const:
            return tests(p == k);
        case Op::mem_ge_const:
            return tests(p >= k);
        case Op::mem_lt_const:
            return tests(p < k);
        case Op::mem_ge_const_s:
            return tests(sp >= sk);
        case Op::mem_lt_const_s:
            return tests(sp < sk);
        case Op::mem_plus_mem:
            return writes(sum, overflow);
        case Op::mem_minus_mem:
            return writes((p - q) & m, p < q);
        case Op::mem_plus_const:
            return writes(ksum, n == 64 ? ksum < p : p + k > m);
        case Op::mem_satplus_mem:
            return writes(overflow ? m : sum, overflow);
        case Op::mem_satminus_mem:
            return writes(p < q ? 0 : p - q, p < q);
        case Op::neg_mem:
            return writes((0 - p) & m);
        case Op::abs_mem:
            return writes((sp < 0 ? 0 - p : p) & m);
        case Op::mul_mem:
            return writes((p * q) & mask(2 * n));
        case Op::mul_mem_s:
            return writes(static_cast<u64>(sp * sq) & mask(2 * n));
        case Op::mul_const:
            return writes(static_cast<u64>(sq * sk) & mask(2 * n));
        case Op::div_mem:
            return writes(q == 0 ? m : p / q);
        case Op::sqrt_mem:
            return writes(isqrt(p));
        default:
            FAIL("no expectation for ", isa::info(op).name);
    }
    return {};
}

constexpr isa::reference::Window one_pixel{.x0 = 77, .y0 = 5, .width = 1, .height = 1};

u64 random_value(test::RandomPrograms& random, std::uint32_t n) {
    const u64 any = u64{random.below(1U << 31)} << 33 ^ u64 { random.below(1U << 31) } << 16 ^
                    random.below(1U << 31);
    const u64 corners[] = {0,           1,   ~u64{0}, u64{1} << (n - 1),
                           mask(n - 1), any, any,     any >> random.below(64)};
    return corners[random.below(8)] & mask(n);
}

void check_outcome(const isa::reference::Reference& pixel, const Outcome& want, Operands o,
                   std::uint32_t width) {
    if (want.value) {
        CHECK(pixel.field(77, 5, o.a, width) == *want.value);
    }
    CHECK(pixel.enabled(77, 5) == want.enable.value_or(true));
    CHECK(pixel.carry(77, 5) == want.carry.value_or(false));
}

/// Runs `op` on one enabled pixel with given values and compares with the definition.
void check_row(test::RandomPrograms& random, Op op, std::uint32_t n) {
    const isa::OpInfo& row = isa::info(op);
    isa::reference::Reference pixel(one_pixel);
    pixel.execute({Op::set_enabs, {}}, {});
    Operands o{random.below(70), 0, n};
    o.b = row.b_role == isa::Role::address ? 136 + random.below(8) : random.below(256);
    const u64 p = random_value(random, n);
    const u64 q = random.below(4) == 0 ? p : random_value(random, n);
    const std::int32_t k =
        random.below(4) == 0 ? static_cast<std::int32_t>(p) : random.coefficient();
    pixel.set_field(77, 5, o.a, n, p);
    if (row.b_role == isa::Role::address) {
        pixel.set_field(77, 5, o.b, n, q);
    }
    const std::int32_t coefficients[] = {k};
    pixel.execute({op, o}, {coefficients, static_cast<std::size_t>(row.words)});
    const u64 k_bits = static_cast<u64>(s64{k}) & mask(n);
    INFO(row.name, " n=", n, " m[a]=", p, " m[b]=", q, " K=", k);
    check_outcome(pixel, expected(op, n, p, q, k_bits, o.b), o, row.at_a(o));
}

bool is_tree(const isa::OpInfo& row) {
    return row.words >= 3;
}

}  // namespace

TEST_CASE("rows of memory and arithmetic agree with 64-bit integers, at every width") {
    const u64 seed = test::seed_or<std::uint64_t>(21);
    INFO("PXPL5_SEED=", seed);
    test::RandomPrograms random(seed);
    for (std::size_t i = 0; i < isa::op_count; ++i) {
        const isa::OpInfo& row = isa::op_table[i];
        if (row.n_max == 0 || is_tree(row) || (row.effects & isa::port) != 0) {
            continue;
        }
        for (std::uint32_t n = 1; n <= row.n_max; ++n) {
            for (int round = 0; round < 12; ++round) {
                check_row(random, static_cast<Op>(i), n);
            }
        }
    }
}

namespace {

/// Q at (77, 5) by the formula.
s64 q_at(const std::array<std::int32_t, 6>& k, bool quadratic) {
    const s64 x = 77, y = 5;
    const s64 linear = k[0] * x + k[1] * y + k[2];
    return quadratic ? linear + k[3] * x * x + k[4] * x * y + k[5] * y * y : linear;
}

Outcome expected_tree(Op op, u64 t, s64 whole_t, u64 q, u64 p, std::uint32_t n) {
    const u64 m = mask(n);
    switch (op) {
        case Op::tree_ge_zero:
        case Op::quad_ge_zero:
            return tests((q >> (n - 1) & 1) == 0);
        case Op::tree_lt_zero:
        case Op::quad_lt_zero:
            return tests((q >> (n - 1) & 1) == 1);
        case Op::tree_lt_mem:
        case Op::quad_lt_mem:
            return tests(t < p);
        case Op::tree_ge_mem:
        case Op::quad_ge_mem:
            return tests(t >= p);
        case Op::tree_into_mem:
        case Op::quad_into_mem:
            return writes(t);
        case Op::tree_clamp_mem:
        case Op::quad_clamp_mem:
            return writes(static_cast<u64>(std::clamp<s64>(whole_t, 0, static_cast<s64>(m))));
        case Op::mem_plus_tree:
        case Op::mem_plus_quad:
            return writes((p + t) & m, ((p + t) & m) < p || t > m - p);
        case Op::mem_minus_tree:
        case Op::mem_minus_quad:
            return writes((p - t) & m, p < t);
        default:
            FAIL("no expectation for ", isa::info(op).name);
    }
    return {};
}

void check_tree_row(test::RandomPrograms& random, Op op, std::uint32_t n) {
    const isa::OpInfo& row = isa::info(op);
    isa::reference::Reference pixel(one_pixel);
    pixel.execute({Op::set_enabs, {}}, {});
    const Operands o{random.below(140), row.b_role == isa::Role::fraction ? random.below(64) : 0,
                     n};
    std::array<std::int32_t, 6> k{};
    std::ranges::generate(k, [&] { return random.coefficient(); });
    const s64 q = q_at(k, row.words == 6);
    // In C++20, >> of a signed number is floor division by a power of two.
    const u64 t = static_cast<u64>(q >> o.b) & mask(n);
    const u64 p = random.below(4) == 0 ? t : random_value(random, n);
    pixel.set_field(77, 5, o.a, n, p);
    pixel.execute({op, o}, {k.data(), static_cast<std::size_t>(row.words)});
    INFO(row.name, " n=", n, " b=", o.b, " Q=", q, " m[a]=", p);
    check_outcome(pixel, expected_tree(op, t, q >> o.b, static_cast<u64>(q), p, n), o, n);
}

}  // namespace

TEST_CASE("tree rows agree with exact integers, at every width") {
    const u64 seed = test::seed_or<std::uint64_t>(22);
    INFO("PXPL5_SEED=", seed);
    test::RandomPrograms random(seed);
    for (std::size_t i = 0; i < isa::op_count; ++i) {
        const isa::OpInfo& row = isa::op_table[i];
        for (std::uint32_t n = 1; is_tree(row) && n <= row.n_max; ++n) {
            for (int round = 0; round < 12; ++round) {
                check_tree_row(random, static_cast<Op>(i), n);
            }
        }
    }
}

TEST_CASE("a linear test of 32 bits enables a half plane, its edge included") {
    isa::reference::Reference pixels;
    const std::int32_t edge[] = {3, -5, 40};
    pixels.execute({Op::set_enabs, {}}, {});
    pixels.execute({Op::tree_ge_zero, {0, 0, 32}}, edge);
    std::size_t wrong = 0;
    for (int y = 0; y < 128; ++y) {
        for (int x = 0; x < 128; ++x) {
            wrong += pixels.enabled(x, y) != (3 * x - 5 * y + 40 >= 0) ? 1 : 0;
        }
    }
    CHECK(wrong == 0);
}

TEST_CASE("one quadratic draws a disc") {
    isa::reference::Reference pixels;
    // r^2 - (x - 60)^2 - (y - 70)^2 >= 0
    const std::int32_t disc[] = {120, 140, 45 * 45 - 60 * 60 - 70 * 70, -1, 0, -1};
    pixels.execute({Op::set_enabs, {}}, {});
    pixels.execute({Op::quad_ge_zero, {0, 0, 32}}, disc);
    std::size_t wrong = 0, inside = 0;
    for (int y = 0; y < 128; ++y) {
        for (int x = 0; x < 128; ++x) {
            const bool in = (x - 60) * (x - 60) + (y - 70) * (y - 70) <= 45 * 45;
            inside += in ? 1 : 0;
            wrong += pixels.enabled(x, y) != in ? 1 : 0;
        }
    }
    CHECK(wrong == 0);
    CHECK(inside == doctest::Approx(3.14159 * 45 * 45).epsilon(0.01));
}

TEST_CASE("overlapping fields are read whole before the result is written") {
    const auto run = [](Op op, Operands o) {
        isa::reference::Reference pixel(one_pixel);
        pixel.execute({Op::set_enabs, {}}, {});
        pixel.set_field(77, 5, 0, 64, 0x0123456789abcdefU);
        pixel.execute({op, o}, {});
        return pixel.field(77, 5, o.a, 32);
    };
    CHECK(run(Op::mem_into_mem, {4, 0, 32}) == 0x89abcdefU);
    CHECK(run(Op::mem_into_mem, {0, 4, 32}) == 0x789abcdeU);
    CHECK(run(Op::mem_plus_mem, {8, 0, 32}) == ((0x6789abcdU + u64{0x89abcdefU}) & mask(32)));
    CHECK(run(Op::mul_mem, {8, 0, 16}) == 0xabcdU * u64{0xcdefU});
    CHECK(run(Op::mul_mem_s, {0, 8, 16}) ==
          (static_cast<u64>(s64{-0x3211} * s64{-0x5433}) & mask(32)));
}

TEST_CASE("the backing store keeps 32 bits of each enabled pixel per block") {
    isa::reference::Reference pixels({.x0 = 0, .y0 = 0, .width = 2, .height = 1});
    pixels.execute({Op::set_enabs, {}}, {});
    pixels.set_field(0, 0, 10, 32, 0xdeadbeef);
    pixels.set_field(1, 0, 10, 32, 0x12345678);
    const std::int32_t left[] = {-1, 0, 0};
    pixels.execute({Op::tree_ge_zero, {0, 0, 8}}, left);
    pixels.execute({Op::bs_write, {10, 127, 0}}, {});
    CHECK(pixels.backing_block(0, 0, 127) == 0xdeadbeef);
    CHECK(pixels.backing_block(1, 0, 127) == 0);
    pixels.execute({Op::set_enabs, {}}, {});
    pixels.execute({Op::bs_read, {100, 127, 0}}, {});
    CHECK(pixels.field(0, 0, 100, 32) == 0xdeadbeef);
    CHECK(pixels.field(1, 0, 100, 32) == 0);
}

TEST_CASE("enable rows do what their sentences say") {
    for (int state = 0; state < 8; ++state) {
        const bool enable = (state & 1) != 0, bit = (state & 2) != 0, carry = (state & 4) != 0;
        const auto after = [&](Op op) {
            isa::reference::Reference pixel(one_pixel);
            pixel.execute({Op::set_enabs, {}}, {});
            pixel.set_field(77, 5, 0, 1, carry ? 1 : 0);
            pixel.execute({Op::mem_plus_mem, {0, 0, 1}}, {});
            pixel.set_field(77, 5, 9, 1, bit ? 1 : 0);
            pixel.execute({enable ? Op::set_enabs : Op::clr_enabs, {}}, {});
            pixel.execute(
                {op, {op == Op::set_enabs || !isa::info(op).pattern.a.mask ? 0U : 9U, 0, 0}}, {});
            CHECK(pixel.field(77, 5, 9, 1) == (op == Op::enab_into_mem ? enable : bit));
            CHECK(pixel.any_enabled() == pixel.enabled(77, 5));
            return pixel.enabled(77, 5);
        };
        CHECK(after(Op::set_enabs));
        CHECK_FALSE(after(Op::clr_enabs));
        CHECK(after(Op::inv_enabs) == !enable);
        CHECK(after(Op::enab_into_mem) == enable);
        CHECK(after(Op::mem_into_enab) == bit);
        CHECK(after(Op::enab_and_mem) == (enable && bit));
        CHECK(after(Op::enab_and_not_mem) == (enable && !bit));
        CHECK(after(Op::enab_or_mem) == (enable || bit));
        CHECK(after(Op::enab_and_carry) == (enable && carry));
    }
}

TEST_CASE("PIXELSTOFB sends a field of every pixel, enabled or not, row by row") {
    isa::reference::Reference pixels;
    std::vector<std::uint32_t> sent;
    pixels.set_readout([&](auto words) { sent.assign(words.begin(), words.end()); });
    const std::int32_t place[] = {1, 128, 0};
    pixels.execute({Op::set_enabs, {}}, {});
    pixels.execute({Op::tree_into_mem, {64, 0, 24}}, place);
    pixels.execute({Op::clr_enabs, {}}, {});
    pixels.execute({Op::pixels_to_fb, {64, 0, 12}}, {});
    REQUIRE(sent.size() == region_pixels);
    for (std::uint32_t i = 0; i < sent.size(); ++i) {
        REQUIRE(sent[i] == (i & 0xfffU));
    }
}
