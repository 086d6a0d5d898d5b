#include "host/machine/computers/network_rate.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

using pxpl5::host::large_answer_bytes;
using pxpl5::host::NetworkRate;
using pxpl5::host::small_answer_bytes;

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

TEST_CASE("answers of another size start again, with the same delay") {
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

/// A network with this delay and rate; the answer to question `late` comes late.
struct Network {
    std::int64_t delay_ns = 0;
    double mb_s = 0;
    int late = -1;
    std::int64_t late_ns = 0;
    std::uint32_t most_bytes = UINT32_MAX;  ///< Larger answers do not come in time.
    std::vector<std::uint32_t> asked = {};

    std::optional<double> measured() {
        return pxpl5::host::measured_mb_s([this](std::uint32_t bytes) {
            const bool is_late = static_cast<int>(asked.size()) == late;
            asked.push_back(bytes);
            const auto ns = delay_ns + static_cast<std::int64_t>(1e3 * bytes / mb_s);
            return bytes > most_bytes ? std::nullopt : std::optional(ns + (is_late ? late_ns : 0));
        });
    }
};

TEST_CASE("one answer that is late changes no rate") {
    for (const double mb_s : {0.5, 50.0, 5000.0}) {
        for (int late = -1; late < (mb_s < 1 ? 6 : 7); ++late) {
            CAPTURE(mb_s);
            CAPTURE(late);
            Network network{2 * ms, mb_s, late, 300 * ms};
            CHECK(network.measured().value() == doctest::Approx(mb_s).epsilon(0.01));
            // A large answer would hold up the beats on a slow network.
            const bool is_slow = mb_s < 1;
            CHECK((std::ranges::count(network.asked, large_answer_bytes) == 0) == is_slow);
        }
    }
}

TEST_CASE("without answers there is no rate") {
    Network dead{2 * ms, 50, -1, 0, 0};
    CHECK(dead.measured() == std::nullopt);
    CHECK(dead.asked.size() == 4);
    Network stopped{2 * ms, 50, -1, 0, small_answer_bytes};
    CHECK(stopped.measured() == std::nullopt);
    CHECK(pxpl5::host::measured_mb_s([](std::uint32_t) { return std::nullopt; }) == std::nullopt);
}

}  // namespace
