// Run folders that several programs make and tidy at the same time.
#include <doctest/doctest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <iterator>
#include <string>
#include <utility>

#include "host/base/error.hpp"
#include "host/machine/run_folder.hpp"
#include "tests/host/io/volume_files.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
namespace fs = std::filesystem;

namespace {

/// Called once, before the next lock that waits.
std::function<void()> before_lock;  // NOLINT(cert-err58-cpp): an empty function does not throw.

/// Makes a run folder in a process of its own, which keeps the newest run. Returns its exit code.
int start_elsewhere(const fs::path& base) {
    const pid_t child = fork();
    if (child == 0) {
        try {
            make_run_folder(base, Topology{}, 1);
        } catch (...) {
            _exit(1);
        }
        _exit(0);
    }
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    return status;
}

std::ptrdiff_t entries_of(const fs::path& folder) {
    return std::distance(fs::directory_iterator(folder), {});
}

}  // namespace

/// The C library's function, with a call before.
extern "C" int flock(int file, int operation) noexcept {
    if (operation == LOCK_EX && before_lock) {
        std::exchange(before_lock, nullptr)();
    }
    return static_cast<int>(syscall(SYS_flock, file, operation));
}

TEST_CASE("a start does not remove the run folder of another start that has no lock yet") {
    const test::TemporaryFolder folder;
    const fs::path base = folder.file("runs");
    int elsewhere = -1;
    before_lock = [&] { elsewhere = start_elsewhere(base); };
    const fs::path run = make_run_folder(base, Topology{}, 1);
    CHECK(elsewhere == 0);
    CHECK(!before_lock);
    CHECK(fs::exists(run / "lock"));
    CHECK(fs::exists(run / "manifest.json"));
    CHECK(fs::exists(run / "config.resolved.json"));
}

TEST_CASE("a run folder that cannot be made is refused with the first reason") {
    // The kernel makes no folders in /sys. Of one in a missing folder, mkdir() would say that.
    try {
        make_run_folder("/sys/pxpl5/runs", Topology{}, 1);
        FAIL("made");
    } catch (const RequestError& error) {
        const std::string reason = error.what();
        CHECK(reason.starts_with("cannot make the run folder /sys/pxpl5/runs/"));
        INFO(reason);
        CHECK(reason.find("No such file") == std::string::npos);
    }
}

TEST_CASE("uploads of ended runs go, but not those of another user, or behind a link") {
    const test::TemporaryFolder folder;
    const fs::path base = folder.file("runs"), elsewhere = folder.file("elsewhere");
    const fs::path own = base / "20250101T000000Z-999999",
                   foreign = base / "20250102T000000Z-999999",
                   link = base / "20250103T000000Z-999999";
    for (const fs::path& run : {own, foreign, elsewhere}) {
        fs::create_directories(run / "uploads");
        std::ofstream(run / "lock");
    }
    fs::create_directory_symlink(elsewhere, link);
    constexpr uid_t other = 65534;
    const bool has_foreign = chown(foreign.c_str(), other, other) == 0;
    if (!has_foreign) {
        MESSAGE("SKIPPED in part: only root can give a folder to another user");
    }
    make_run_folder(base, Topology{});
    CHECK(!fs::exists(own / "uploads"));
    CHECK(fs::exists(foreign / "uploads") == has_foreign);
    CHECK(fs::exists(elsewhere / "uploads"));
}

TEST_CASE("two run folders of one second and one program have two names") {
    const test::TemporaryFolder folder;
    const fs::path base = folder.file("runs");
    const fs::path one = make_run_folder(base, Topology{}), two = make_run_folder(base, Topology{});
    CHECK(one != two);
    CHECK(entries_of(base) == 2);
    CHECK(entries_of(one) == 3);
    CHECK(entries_of(two) == 3);
}

TEST_CASE("a folder that a killed start has left goes with a later start, and a young one stays") {
    const test::TemporaryFolder folder;
    const fs::path base = folder.file("runs");
    // The clock was set back after the start of cccccc: that program may be at work.
    for (const auto& [name, age_h] : std::map<std::string, int>{{".new-aaaaaa", 2},
                                                                {".new-bbbbbb", 0},
                                                                {".new-cccccc", -1},
                                                                {".new-dddddd", 2},
                                                                {".new-things", 2},
                                                                {".new-public", 2},
                                                                {".new-much-longer", 2},
                                                                {".news", 2}}) {
        fs::create_directories(base / name);
        fs::permissions(base / name, fs::perms::owner_all);
        if (name == ".new-dddddd") {
            std::ofstream(base / name / "lock");
            std::ofstream(base / name / "config.resolved.json") << "{}";
        }
        if (name == ".new-things") {
            std::ofstream(base / name / "thesis.txt") << "text";
        }
        if (name == ".new-public") {
            fs::permissions(base / name, fs::perms(0755));
        }
        fs::last_write_time(base / name,
                            fs::file_time_type::clock::now() - std::chrono::hours(age_h));
    }
    make_run_folder(base, Topology{});
    CHECK(!fs::exists(base / ".new-aaaaaa"));
    CHECK(!fs::exists(base / ".new-dddddd"));
    CHECK(fs::exists(base / ".new-things/thesis.txt"));
    CHECK(fs::exists(base / ".new-public"));
    CHECK(fs::exists(base / ".new-bbbbbb"));
    CHECK(fs::exists(base / ".new-cccccc"));
    CHECK(fs::exists(base / ".new-much-longer"));
    CHECK(fs::exists(base / ".news"));
}

TEST_CASE("after the clock was set back runs of a later time do not displace the run that starts") {
    const test::TemporaryFolder folder;
    const fs::path base = folder.file("runs");
    for (const char* name : {"29990101T000000Z-999999", "29990102T000000Z-999999"}) {
        fs::create_directories(base / name);
        std::ofstream(base / name / "lock");
    }
    const fs::path run = make_run_folder(base, Topology{}, 1);
    CHECK(fs::exists(run / "manifest.json"));
    CHECK(fs::exists(base / "29990102T000000Z-999999"));
    CHECK(!fs::exists(base / "29990101T000000Z-999999"));
    CHECK(make_run_folder(base, Topology{}, 1) != run);
    CHECK(fs::exists(run / "manifest.json"));
}

TEST_CASE("a private folder is made for the owner, and nothing else in its place is used") {
    const test::TemporaryFolder folder;
    const fs::path made = folder.file("made"), open = folder.file("open");
    make_private_folder(made);
    CHECK((fs::status(made).permissions() & fs::perms::all) == fs::perms::owner_all);
    make_private_folder(made);  // It exists.
    fs::create_directory(open);
    fs::permissions(open, fs::perms::owner_all | fs::perms::group_read);
    CHECK_THROWS_AS(make_private_folder(open), RequestError);
    fs::create_directory_symlink(made, folder.file("link"));
    CHECK_THROWS_AS(make_private_folder(folder.file("link")), RequestError);
    CHECK_THROWS_AS(make_private_folder(folder.file("none") + "/saved"), RequestError);
}
