// Where files are written, and why files cannot be written or read.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "host/base/kernel/owned_descriptor.hpp"
#include "host/base/part_file.hpp"
#include "tests/host/io/volume_files.hpp"

using namespace pxpl5::host;
using pxpl5::test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

std::string text_of(const std::string& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Returns why that failed.
std::string write(const std::string& path, const std::string& text) {
    PartFile file(path);
    file.write(text);
    return file.keep();
}

}  // namespace

TEST_CASE("a file that is written under the name of a link takes the place of the link's target") {
    const TemporaryFolder folder;
    fs::create_directories(folder.file("far/away"));
    folder.write("far/away/real.txt", "old");
    fs::create_symlink("far/away/hop.txt", folder.file("link.txt"));
    fs::create_symlink("real.txt", folder.file("far/away/hop.txt"));
    CHECK(place_of(folder.file("link.txt")) == folder.file("far/away/real.txt"));
    CHECK(write(folder.file("link.txt"), "new") == "");
    CHECK(text_of(folder.file("far/away/real.txt")) == "new");
    CHECK(fs::is_symlink(folder.file("link.txt")));
    CHECK(fs::is_symlink(folder.file("far/away/hop.txt")));
    CHECK(std::distance(fs::directory_iterator(folder.file("far/away")), {}) == 2);
}

TEST_CASE("a link to a file that does not exist yet makes that file") {
    const TemporaryFolder folder;
    fs::create_directory(folder.file("data"));
    fs::create_symlink(folder.file("data/new.txt"), folder.file("link.txt"));
    CHECK(write(folder.file("link.txt"), "text") == "");
    CHECK(text_of(folder.file("data/new.txt")) == "text");
    fs::create_symlink(folder.file("gone/new.txt"), folder.file("lost.txt"));
    CHECK(wrong_place(folder.file("lost.txt")) ==
          folder.file("lost.txt") + ": its folder " + folder.file("gone") + " does not exist");
}

TEST_CASE("links that lead in a circle come to an end") {
    const TemporaryFolder folder;
    fs::create_symlink(folder.file("b"), folder.file("a"));
    fs::create_symlink(folder.file("a"), folder.file("b"));
    CHECK(write(folder.file("a"), "text") == "");  // It replaces one of the two.
}

TEST_CASE("a link of another user in a shared folder is replaced and not followed") {
    if (geteuid() != 0) {
        MESSAGE("SKIPPED: only root can make a link of another user");
        return;
    }
    constexpr unsigned other_user = 65534;
    const TemporaryFolder folder;
    folder.write("own.txt", "own");
    fs::create_directory(folder.file("shared"));
    REQUIRE(chmod(folder.file("shared").c_str(), 01777) == 0);
    fs::create_symlink(folder.file("own.txt"), folder.file("shared/trap.txt"));
    CHECK(place_of(folder.file("shared/trap.txt")) == folder.file("own.txt"));
    REQUIRE(lchown(folder.file("shared/trap.txt").c_str(), other_user, other_user) == 0);
    CHECK(write(folder.file("shared/trap.txt"), "new") == "");
    CHECK(text_of(folder.file("own.txt")) == "own");
    CHECK(text_of(folder.file("shared/trap.txt")) == "new");
}

TEST_CASE("folders, FIFOs and devices are no places for a file") {
    const TemporaryFolder folder;
    fs::create_directory(folder.file("f.stl"));
    CHECK(wrong_place(folder.file("f.stl")) ==
          folder.file("f.stl") + ": is a folder, not a file: give the name of a file in it");
    REQUIRE(mkfifo(folder.file("pipe").c_str(), 0600) == 0);
    CHECK(wrong_place(folder.file("pipe")) ==
          folder.file("pipe") + ": is a FIFO, not a file: give the name of a file");
    CHECK(wrong_place("/dev/null") ==
          "/dev/null: is a device, not a file: give the name of a file");
    CHECK(wrong_place(folder.file("new.stl")) == "");
    CHECK(wrong_place("new.stl") == "");
}

TEST_CASE("a file that cannot be read is named by what it is") {
    const TemporaryFolder folder;
    CHECK(why_unreadable(folder.write("f", "text")) == "");
    CHECK(why_unreadable(folder.file("none")) == "does not exist");
    CHECK(why_unreadable(folder.file("f/none")) == "does not exist");
    CHECK(why_unreadable(folder.file("")) == "is a folder, not a file");
    CHECK(why_unreadable("/dev/zero") == "is a device, not a file");
    for (const char* path : {"/proc/self/mem", "/proc/kmsg", "/sys/kernel/mm/transparent_hugepage",
                             "/proc/self/status"}) {
        CAPTURE(path);
        CHECK((is_of_kernel(path) || !fs::exists(path)));
    }
    CHECK(why_unreadable("/proc/self/status") == "is a file of the kernel, not a stored file");
    const OwnedDescriptor opened(open(folder.file("f").c_str(), O_RDONLY | O_CLOEXEC));
    CHECK(why_unreadable(fmt::format("/proc/self/fd/{}", opened.fd)) == "");
    REQUIRE(mkfifo(folder.file("pipe").c_str(), 0600) == 0);
    CHECK(why_unreadable(folder.file("pipe")) == "is a FIFO, not a file");
}

TEST_CASE("unfinished files of a killed writer go, and no other file does") {
    const TemporaryFolder folder;
    const std::string digits = "0123456789abcdef";
    fs::create_directory(folder.file("far"));
    fs::create_symlink("far/b.obj", folder.file("link.obj"));
    for (const char* name :
         {"a.b.stl", ".a.b.DIGITS.part.ply", ".c.DIGITS.part.stl", ".a.b.DIGITS.stl",
          ".a.b.0123.part.stl", ".a.b.DIGITS.part.mtl", ".a.b.DIGITS.part.stl",
          "far/.b.DIGITS.part.obj", "far/.b.DIGITS.part.mtl"}) {
        std::string named = name;
        if (const std::size_t at = named.find("DIGITS"); at != std::string::npos) {
            named.replace(at, 6, digits);
        }
        folder.write(named, "x");
    }
    const auto files = [&] {
        const auto all = fs::recursive_directory_iterator(folder.file(""));
        return std::count_if(begin(all), end(all),
                             [](const auto& entry) { return entry.is_regular_file(); });
    };
    const auto now = fs::last_write_time(folder.file("a.b.stl"));
    remove_parts_of(folder.file("a.b.stl"), now + std::chrono::hours(1));
    CHECK(files() == 9);  // They are older than the writer.
    remove_parts_of(folder.file("a.b.stl"), now - std::chrono::hours(1));
    CHECK(files() == 8);
    CHECK_FALSE(fs::exists(folder.file(".a.b." + digits + ".part.stl")));
    remove_parts_of(folder.file("link.obj"), now - std::chrono::hours(1));
    CHECK(files() == 6);
    remove_parts_of(folder.file("none/x.stl"), now - std::chrono::hours(1));
}

TEST_CASE("abandoned files go, and those that are young, in use or of the user do not") {
    const TemporaryFolder folder;
    const std::string digits = "0123456789abcdef", other = "fedcba9876543210";
    const std::string old = folder.file(".a." + digits + ".part.stl");
    const std::string young = folder.file(".a." + other + ".part.stl");
    const std::string of_b = folder.file(".b." + digits + ".part.png");
    const std::string no_suffix = folder.file(".notes." + digits + ".part");
    const std::string of_user = folder.file("c." + digits + ".part.png");
    const std::string short_one = folder.file("." + digits + ".part.png");
    const std::string no_part = folder.file(".d." + digits + ".apart.png");
    for (const std::string& path : {old, young, of_b, no_suffix, of_user, short_one, no_part}) {
        REQUIRE(write(path, "x") == "");
    }
    const auto an_hour_ago = fs::file_time_type::clock::now() - std::chrono::hours(1);
    PartFile used(folder.file("a.stl"));
    used.write("text");
    REQUIRE(used.finish() == "");
    for (const auto& entry : fs::directory_iterator(folder.file(""))) {
        if (entry.path() != young) {
            fs::last_write_time(entry.path(), an_hour_ago);
        }
    }
    remove_abandoned_parts(folder.file("a.stl"));
    CHECK_FALSE(fs::exists(old));
    CHECK(fs::exists(young));
    CHECK_FALSE(fs::exists(of_b));
    CHECK_FALSE(fs::exists(no_suffix));
    CHECK(fs::exists(of_user));
    CHECK(fs::exists(short_one));
    CHECK(fs::exists(no_part));
    CHECK(used.keep() == "");
    CHECK(text_of(folder.file("a.stl")) == "text");
    remove_abandoned_parts(folder.file("none/a.stl"));
}
