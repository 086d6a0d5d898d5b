#include "host/machine/computers/join/key.hpp"

#include <doctest/doctest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <functional>

#include "host/base/error.hpp"
#include "host/base/state_folder.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

std::string error_of(const std::function<void()>& act) {
    try {
        act();
    } catch (const RequestError& error) {
        return error.what();
    }
    return "";
}

std::string error_of_file(const std::filesystem::path& file) {
    return error_of([&] { read_key_file(file); });
}

std::string error_of_machine(const ClusterSettings& cluster, bus::Protection protection) {
    return error_of([&] { machine_key(cluster, protection); });
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
    for (const std::size_t part : {60, 100}) {  // A letter of the open key, and of the secret.
        for (const char letter : {text[part] == 'a' ? 'b' : 'a', '~'}) {
            CAPTURE(letter);
            other = text;
            other[part] = letter;
            CHECK(error_of([&] {
                      parse_key(other, "the key file k");
                  }).starts_with("the key file k has a damaged key: its two parts of 40 "));
        }
    }
}

TEST_CASE("key: a key file is for its owner alone") {
    const TemporaryFolder folder("pxpl5-key-test");
    const std::filesystem::path file = folder.path() / "join.key";
    const bus::Credentials made =
        bus::make_credentials(bus::Protection::curve, bus::Reach::network);
    write_key_file(file, made);
    CHECK(are_equal(read_key_file(file), made));
    CHECK_THROWS_AS(write_key_file(file, made), RequestError);  // Never into an older file.
    if (constexpr uid_t other = 65534; chown(file.c_str(), other, other) == 0) {
        CHECK(error_of_file(file) == "the key file " + file.string() +
                                         " belongs to user 65534, who knows the key; this program "
                                         "runs as user 0. Use a key file of your own");
        REQUIRE(chown(file.c_str(), 0, 0) == 0);
    } else {
        MESSAGE("SKIPPED in part: only root can give a file to another user");
    }
    REQUIRE(chmod(file.c_str(), 0640) == 0);
    CHECK(error_of_file(file) == "the key file " + file.string() +
                                     " has mode 0640, so others may read it. Run: chmod 600 " +
                                     file.string());
    std::filesystem::remove(file);
    CHECK(error_of_file(file) ==
          "cannot read the key file " + file.string() + ": No such file or directory");
}

TEST_CASE("key: a folder and a FIFO are named as such, before their mode") {
    const TemporaryFolder folder("pxpl5-key-test");
    const std::filesystem::path fifo = folder.path() / "fifo";
    REQUIRE(mkfifo(fifo.c_str(), 0666) == 0);
    for (const std::filesystem::path& path : {folder.path(), fifo}) {
        CHECK(error_of_file(path) == "the key file " + path.string() +
                                         " is a folder, a device or a FIFO: give a file that "
                                         "'pxpl5 key' has made");
    }
}

TEST_CASE("key: a file of root for one group is accepted, as Kubernetes mounts a Secret") {
    const TemporaryFolder folder("pxpl5-key-test");
    // Kubernetes changes all files of a Secret at once, by a link.
    std::filesystem::create_directory(folder.path() / "..2026");
    std::filesystem::create_directory_symlink("..2026", folder.path() / "..data");
    std::filesystem::create_symlink("..data/key", folder.path() / "key");
    const std::filesystem::path file = folder.path() / "key", target = folder.path() / "..2026/key";
    const bus::Credentials made = make_key();
    write_key_file(target, made);
    const std::string refusal = "others may read it";
    for (const mode_t mode : {0400, 0440, 0444, 0460, 0640, 0441}) {
        CAPTURE(mode);
        REQUIRE(chmod(target.c_str(), mode) == 0);
        const bool is_sound = mode == 0400 || (mode == 0440 && geteuid() == 0);
        CHECK((error_of_file(file).find(refusal) == std::string::npos) == is_sound);
        if (is_sound) {
            CHECK(are_equal(read_key_file(file), made));
        }
    }
    if (geteuid() == 0) {  // The owner of such a file is root, and no other user.
        constexpr uid_t nobody = 65534;
        REQUIRE(chown(target.c_str(), nobody, nobody) == 0);
        REQUIRE(chmod(target.c_str(), 0440) == 0);
        CHECK(error_of_file(file).find(refusal) != std::string::npos);
    }
}

TEST_CASE("key: a machine takes the user's key for engine wait alone, and only with encryption") {
    const TemporaryFolder folder("pxpl5-key-test");
    const std::filesystem::path file = folder.path() / "key", plain = folder.path() / "plain";
    const bus::Credentials made = make_key();
    write_key_file(file, made);
    write_key_file(plain, bus::make_credentials(bus::Protection::plain_tcp, bus::Reach::network));
    ClusterSettings cluster;
    cluster.engine = Engine::wait;
    CHECK(!are_equal(machine_key(cluster, bus::Protection::curve), made));
    cluster.key_file = file.string();
    CHECK(are_equal(machine_key(cluster, bus::Protection::curve), made));
    CHECK(
        error_of_machine(cluster, bus::Protection::plain_tcp) ==
        "--key-file " + file.string() +
            ": a key of your own is for --engine wait without --insecure-tcp; the engine is wait");
    cluster.key_file = plain.string();
    CHECK(error_of_machine(cluster, bus::Protection::curve) ==
          "the key file " + plain.string() +
              " has a key of a machine without encryption. Make another one with: pxpl5 key");
    cluster.key_file = file.string();
    for (const Engine engine : {Engine::local, Engine::ssh, Engine::slurm}) {
        cluster.engine = engine;
        CHECK(error_of_machine(cluster, bus::Protection::curve).find("is for --engine wait") !=
              std::string::npos);
    }
}
