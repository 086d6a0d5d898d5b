// Tests division, square root and multiplication at the limits of their floating-point methods.
#include <cmath>

#include "tests/renderer_firmware/targets.hpp"

using namespace pxpl5;
using renderer::fast::Fast;

namespace {

void run(Fast& fast, isa::Op op, isa::Operands operands, std::vector<std::int32_t> k = {}) {
    fast.execute({op, operands}, k);
}

/// Stores base + 128 * y + x (32 bits) at m[a] of every pixel.
void put_ramp(Fast& fast, std::uint32_t a, std::uint32_t base) {
    run(fast, isa::Op::tree_into_mem, {a, 0, 32}, {1, 128, static_cast<std::int32_t>(base)});
}

/// Returns floor(sqrt(v)) with integers only.
std::uint64_t integer_root(std::uint64_t v) {
    std::uint64_t root = 0;
    for (std::uint64_t bit = std::uint64_t{1} << 16; bit != 0; bit >>= 1) {
        root += (root + bit) * (root + bit) <= v ? bit : 0;
    }
    return root;
}

template <typename Check>
void each_pixel(const Check& check) {
    for (int y = 0; y < region_px; ++y) {
        for (int x = 0; x < region_px; ++x) {
            check(x, y, static_cast<std::uint32_t>(y * region_px + x));
        }
    }
}

}  // namespace

TEST_CASE("SQRTMEM is exact for every number of 23 bits, and around every square of 32 bits") {
    test::on_every_target([](Fast& fast) {
        run(fast, isa::Op::set_enabs, {});
        std::uint64_t wrong = 0;
        for (std::uint32_t base = 0; base < 1U << 23; base += 16384) {
            put_ramp(fast, 3, base);
            run(fast, isa::Op::sqrt_mem, {3, 0, 23});
            each_pixel([&](int x, int y, std::uint32_t i) {
                wrong += fast.field(x, y, 3, 23) == integer_root(base + i) ? 0 : 1;
            });
        }
        CHECK(wrong == 0);
        // Pixel i holds k * k + offset with k = 49152 + i: 32-bit squares and adjacent numbers.
        for (const std::int32_t offset : {-1, 0, 1}) {
            put_ramp(fast, 0, 49152);
            run(fast, isa::Op::mem_into_mem, {64, 0, 32});
            run(fast, isa::Op::mul_mem, {0, 64, 32});
            run(fast, isa::Op::mem_plus_const, {0, 0, 32}, {offset});
            run(fast, isa::Op::sqrt_mem, {0, 0, 32});
            each_pixel([&](int x, int y, std::uint32_t i) {
                const std::uint64_t k = 49152 + i;
                wrong += fast.field(x, y, 0, 32) == (offset < 0 ? k - 1 : k) ? 0 : 1;
            });
        }
        CHECK(wrong == 0);
    });
}

TEST_CASE("DIVMEM is exact next to every multiple, in 23, 24 and 32 bits") {
    test::on_every_target([](Fast& fast) {
        run(fast, isa::Op::set_enabs, {});
        std::uint64_t wrong = 0;
        for (const std::uint32_t n : {8U, 22U, 23U, 24U, 31U, 32U}) {
            const std::uint64_t top = (std::uint64_t{1} << n) - 1;
            // Divisors q come from the ramp; numerators are the largest multiple of q and adjacent
            // numbers.
            for (const std::uint32_t base : {1U, 1000U, 1U << 11, 1U << 16, 1U << 20}) {
                if (base + 16384 > top) {
                    continue;
                }
                for (const int offset : {-1, 0, 1}) {
                    put_ramp(fast, 100, base);
                    // top - top % q, computed by the division under test, which is checked below.
                    run(fast, isa::Op::const_into_mem, {0, 0, 64}, {0});
                    run(fast, isa::Op::const_into_mem, {0, 0, n}, {-1});
                    run(fast, isa::Op::div_mem, {0, 100, n});
                    each_pixel([&](int x, int y, std::uint32_t i) {
                        wrong += fast.field(x, y, 0, n) == top / (base + i) ? 0 : 1;
                    });
                    run(fast, isa::Op::mul_mem, {0, 100, n});
                    run(fast, isa::Op::mem_plus_const, {0, 0, n}, {offset});
                    run(fast, isa::Op::div_mem, {0, 100, n});
                    each_pixel([&](int x, int y, std::uint32_t i) {
                        const std::uint64_t q = base + i;
                        const std::uint64_t p =
                            (top / q * q + static_cast<std::uint64_t>(std::int64_t{offset})) & top;
                        wrong += fast.field(x, y, 0, n) == p / q ? 0 : 1;
                    });
                }
            }
        }
        CHECK(wrong == 0);
    });
}

TEST_CASE("DIVMEM by 0 gives all ones") {
    test::on_every_target([](Fast& fast) {
        run(fast, isa::Op::set_enabs, {});
        for (const std::uint32_t n : {1U, 23U, 24U, 32U}) {
            put_ramp(fast, 40, 5);
            run(fast, isa::Op::clear_mem, {100, 0, 32});
            run(fast, isa::Op::div_mem, {40, 100, n});
            CHECK(fast.field(17, 33, 40, n) == (std::uint64_t{1} << n) - 1);
        }
    });
}

TEST_CASE("signed products of any width have the right upper half") {
    test::on_every_target([](Fast& fast) {
        run(fast, isa::Op::set_enabs, {});
        for (const std::uint32_t n : {2U, 15U, 16U, 17U, 31U, 32U}) {
            for (const std::int32_t k : {-1, 1, INT32_MIN, INT32_MAX, 0x5A5A5A5A, -77777}) {
                put_ramp(fast, 130, 0x7FFFF000U);
                run(fast, isa::Op::mul_const, {5, 130, n}, {k});
                const auto cut = [n](std::uint32_t v) {
                    const int gone = 32 - static_cast<int>(n);
                    return std::int64_t{static_cast<std::int32_t>(v << gone) >> gone};
                };
                std::uint64_t wrong = 0;
                each_pixel([&](int x, int y, std::uint32_t i) {
                    const std::int64_t p =
                        cut(0x7FFFF000U + i) * cut(static_cast<std::uint32_t>(k));
                    const std::uint64_t low = ~std::uint64_t{0} >> (64 - 2 * n);
                    wrong +=
                        fast.field(x, y, 5, 2 * n) == (static_cast<std::uint64_t>(p) & low) ? 0 : 1;
                });
                CHECK(wrong == 0);
            }
        }
    });
}
