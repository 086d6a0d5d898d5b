#include "ringbus/zmq/credentials.hpp"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <stdexcept>

using namespace pxpl5::bus;

TEST_SUITE("ringbus/credentials") {
    TEST_CASE("a child inherits what the host has made, through a pipe that it closes") {
        for (const Protection protection :
             {Protection::files, Protection::curve, Protection::plain_tcp}) {
            const Credentials made = make_credentials(protection);
            CHECK(made.keys.has_value() == (protection == Protection::curve));
            CHECK(made.allows_plain_tcp == (protection == Protection::plain_tcp));
            const int pipe = credentials_pipe(made);
            const Credentials inherited = inherit_credentials(pipe);
            CHECK(fcntl(pipe, F_GETFD) == -1);
            CHECK(inherited.secret.low() == made.secret.low());
            CHECK(inherited.secret.high() == made.secret.high());
            CHECK(inherited.allows_plain_tcp == made.allows_plain_tcp);
            REQUIRE(inherited.keys.has_value() == made.keys.has_value());
            if (made.keys) {
                CHECK(made.keys->open.size() == 40);
                CHECK(inherited.keys->open == made.keys->open);
                CHECK(inherited.keys->secret == made.keys->secret);
            }
        }
    }

    TEST_CASE("no two machines have the same secret or keys") {
        const Credentials a = make_credentials(Protection::curve),
                          b = make_credentials(Protection::curve);
        CHECK(a.secret.low() != b.secret.low());
        CHECK(a.secret.high() != b.secret.high());
        CHECK(a.keys->open != b.keys->open);
        CHECK(a.keys->secret != b.keys->secret);
    }

    TEST_CASE("a descriptor without credentials is an error") {
        std::array<int, 2> ends{};
        REQUIRE(pipe(ends.data()) == 0);
        REQUIRE(write(ends[1], "short", 5) == 5);
        close(ends[1]);
        CHECK_THROWS_AS(inherit_credentials(ends[0]), std::runtime_error);
        CHECK_THROWS_AS(inherit_credentials(1'000'000), std::runtime_error);
    }
}
