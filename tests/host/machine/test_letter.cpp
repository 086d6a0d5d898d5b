#include "host/machine/computers/join/letter.hpp"

#include <doctest/doctest.h>

using namespace pxpl5::host;

TEST_CASE("letter: a letter reads back") {
    join::EndedT ended;
    ended.name = "gp-3";
    ended.signal = 9;
    const join::LetterT letter = unpacked_letter(packed_letter(ended));
    REQUIRE(letter.word.AsEnded() != nullptr);
    CHECK(letter.word.AsEnded()->name == "gp-3");
    CHECK(letter.word.AsEnded()->signal == 9);
}

TEST_CASE("letter: bytes that are no letter are refused, whatever was changed in them") {
    join::EndedT ended;
    ended.name = "gp-3";
    const std::vector<std::uint8_t> good = packed_letter(ended);
    constexpr std::size_t padding = 3;  // Bytes at the end that mean nothing.
    for (std::size_t size = 0; size < good.size() - padding; ++size) {
        CAPTURE(size);
        CHECK_THROWS_AS(unpacked_letter({good.data(), size}), BadLetter);
    }
    std::vector<std::uint8_t> other = good;
    other[4] ^= 1;  // The identifier.
    CHECK_THROWS_AS(unpacked_letter(other), BadLetter);
}
