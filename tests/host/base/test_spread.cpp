#include <doctest/doctest.h>

#include "host/base/spread.hpp"

using namespace pxpl5::host;

TEST_CASE("a spread is of values that were there, by nearest rank") {
    const Spread odd = spread_of({3, 1, 2});
    CHECK(odd.median == 2);
    CHECK(odd.p95 == 3);
    CHECK(odd.max == 3);
    const Spread even = spread_of({4, 1, 3, 2});
    CHECK(even.median == 2);

    std::vector<double> hundred;
    for (int i = 100; i > 0; --i) {
        hundred.push_back(i);
    }
    const Spread many = spread_of(hundred);
    CHECK(many.median == 50);
    CHECK(many.p95 == 95);
    CHECK(many.max == 100);

    CHECK(spread_of({7}).median == 7);
    CHECK(spread_of({}).max == 0);
}
