#include "host/machine/computers/key.hpp"

#include <doctest/doctest.h>
#include <sys/stat.h>

#include <fstream>

#include "host/base/error.hpp"
#include "host/base/state_folder.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

std::string error_of_file(const std::filesystem::path& file) {
    try {
        read_key_file(file);
    } catch (const RequestError& error) {
        return error.what();
    }
    return "";
}

bool are_equal(const bus::Credentials& a, const bus::Credentials& b) {
    return a.secret.low() == b.secret.low() && a.secret.high() == b.secret.high() &&
           a.keys.has_value() == b.keys.has_value() &&
           (!a.keys || (a.keys->open == b.keys->open && a.keys->secret == b.keys->secret)) &&
           a.allows_network == b.allows_network && a.allows_plain_tcp == b.allows_plain_tcp;
}

}  // namespace

TEST_CASE("key: a key is one line that reads back") {
    for (const bus::Protection protection : {bus::Protection::curve, bus::Protection::plain_tcp}) {
        const bus::Credentials made = bus::make_credentials(protection, bus::Reach::network);
        const std::string text = key_text(made);
        CHECK(text.find('\n') + 1 == text.size());
        CHECK(are_equal(parse_key(text, "test"), made));
    }
}

TEST_CASE("key: what is not a whole key is refused") {
    const std::string text =
        key_text(bus::make_credentials(bus::Protection::curve, bus::Reach::network));
    for (std::size_t size = 0; size + 1 < text.size(); size += 7) {
        CAPTURE(size);
        CHECK_THROWS_AS(parse_key(text.substr(0, size), "test"), RequestError);
    }
    std::string other = text;
    other.replace(0, 5, "xxxxx");
    CHECK_THROWS_AS(parse_key(other, "test"), RequestError);
}

TEST_CASE("key: a key file is for its owner alone") {
    const TemporaryFolder folder("pxpl5-key-test");
    const std::filesystem::path file = folder.path() / "join.key";
    const bus::Credentials made =
        bus::make_credentials(bus::Protection::curve, bus::Reach::network);
    write_key_file(file, made);
    CHECK(are_equal(read_key_file(file), made));
    CHECK_THROWS_AS(write_key_file(file, made), RequestError);  // Never into an older file.
    REQUIRE(chmod(file.c_str(), 0640) == 0);
    CHECK(error_of_file(file) == "the key file " + file.string() +
                                     " has mode 0640, so others may read it. Run: chmod 600 " +
                                     file.string());
    std::filesystem::remove(file);
    CHECK(error_of_file(file) ==
          "cannot read the key file " + file.string() + ": No such file or directory");
}
