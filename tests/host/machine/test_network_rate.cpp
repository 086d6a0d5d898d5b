#include "host/machine/computers/network_rate.hpp"

#include <doctest/doctest.h>

using pxpl5::host::NetworkRate;

namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::uint32_t full_bytes = 1'000'000;

TEST_CASE("a late empty answer does not make a network seem fast") {
    NetworkRate rate;
    rate.add_empty(390 * ms);  // By chance.
    rate.add_full(full_bytes, 400 * ms);
    CHECK(rate.mb_s() == doctest::Approx(100));
    rate.add_empty(200 * ms);
    CHECK(rate.mb_s() == doctest::Approx(5));
    rate.add_empty(300 * ms);
    CHECK(rate.mb_s() == doctest::Approx(5));
}

TEST_CASE("a late answer with bytes does not make a network seem slow") {
    NetworkRate rate;
    rate.add_empty(2 * ms);
    rate.add_full(full_bytes, 1002 * ms);  // By chance.
    CHECK(rate.mb_s() == doctest::Approx(1));
    rate.add_full(full_bytes, 7 * ms);
    CHECK(rate.mb_s() == doctest::Approx(200));
    rate.add_full(full_bytes, 502 * ms);
    CHECK(rate.mb_s() == doctest::Approx(200));
}

TEST_CASE("answers of another size begin anew, with the same delay") {
    NetworkRate rate;
    rate.add_empty(2 * ms);
    rate.add_full(full_bytes / 10, 3 * ms);
    CHECK(rate.mb_s() == doctest::Approx(100));
    rate.add_full(full_bytes, 7 * ms);
    CHECK(rate.mb_s() == doctest::Approx(200));
}

TEST_CASE("an answer with bytes that is faster than all empty ones is as fast as can be") {
    NetworkRate rate;
    rate.add_empty(3 * ms);
    rate.add_full(full_bytes, 2 * ms);
    CHECK(rate.mb_s() == doctest::Approx(1e9));
}

}  // namespace
