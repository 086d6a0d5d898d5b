// The sandbox of the io process, tried by children that confine themselves.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <atomic>
#include <csignal>
#include <functional>
#include <thread>

#include "host/base/kernel/protections.hpp"
#include "host/io/sandbox/sandbox.hpp"
#include "tests/host/io/sandbox/confined.hpp"
#include "tests/host/io/sandbox/skipped.hpp"
#include "tests/host/io/volume_files.hpp"

using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

constexpr std::uint64_t small_file = std::uint64_t{2} << 20;

/// The error of opening `path`, or 0.
int error_of_open(const std::string& path, int flags = O_RDONLY) {
    return error_of_call(open(path.c_str(), flags | O_CLOEXEC, 0600));
}

/// The end of a child that runs `action` once it is confined to `needs`.
Ending confined(const Needs& needs, const std::function<int()>& action) {
    return in_child([&] {
        confine(needs);
        return action();
    });
}

/// An input folder, an output folder and a private one.
struct Places {
    TemporaryFolder base;
    Places() {
        for (const char* name : {"in", "in/deep", "out", "out/deep", "private"}) {
            std::filesystem::create_directory(base.file(name));
        }
        for (const char* name : {"in/a", "in/deep/b", "out/old", "private/secret"}) {
            base.write(name, "text");
        }
        std::filesystem::create_symlink(base.file("private/secret"), base.file("in/link"));
        std::filesystem::create_directory_symlink(base.file("private"), base.file("in/way"));
    }
    Needs reading() const { return {Task::read, {{base.file("in")}, {}, {}}, 0}; }
    Needs writing() const { return {Task::write, {{}, {}, {base.file("out")}}, small_file}; }
    int opened(const Needs& needs, const std::string& name, int flags = O_RDONLY) const {
        return confined(needs, [&] { return error_of_open(base.file(name), flags); }).code;
    }
};

}  // namespace

TEST_SUITE("host/io/sandbox") {
    TEST_CASE("a reader opens what lies beneath its folder, and nothing else") {
        if (lacks_landlock()) {
            return;
        }
        const Places places;
        CHECK(places.opened(places.reading(), "in/a") == 0);
        CHECK(places.opened(places.reading(), "in/deep/b") == 0);
        CHECK(places.opened(places.reading(), "in", O_RDONLY | O_DIRECTORY) == 0);
        CHECK(places.opened(places.reading(), "private/secret") == EACCES);
        CHECK(places.opened(places.reading(), "private", O_RDONLY | O_DIRECTORY) == EACCES);
        CHECK(confined(places.reading(), [] { return error_of_open("/etc/passwd"); }).code ==
              EACCES);
        CHECK(places.opened(places.reading(), "in/link") == EACCES);
        CHECK(places.opened(places.reading(), "in/way/secret") == EACCES);
        CHECK(places.opened(places.reading(), "in/../private/secret") == EACCES);
    }

    TEST_CASE("a reader of one file cannot open the file beside it") {
        if (lacks_landlock()) {
            return;
        }
        const Places places;
        const Needs one{
            Task::read, {{places.base.file("in/link")}, {places.base.file("in")}, {}}, 0};
        CHECK(places.opened(one, "in/link") == 0);  // The user has named this link.
        CHECK(places.opened(one, "in/a") == EACCES);
        CHECK(places.opened(one, "in", O_RDONLY | O_DIRECTORY) == 0);
    }

    TEST_CASE("a reader changes, makes and removes no file") {
        if (lacks_landlock() || lacks_filters()) {
            return;
        }
        const Places places;
        CHECK(places.opened(places.reading(), "in/a", O_WRONLY) == EACCES);
        CHECK(places.opened(places.reading(), "in/new", O_WRONLY | O_CREAT) == EACCES);
        CHECK(places.opened(places.reading(), "out/new", O_WRONLY | O_CREAT) == EACCES);
        const std::string name = places.base.file("in/a");
        const auto error = [&](const std::function<int()>& act) {
            return confined(places.reading(), [&] { return error_of_call(act()); }).code;
        };
        CHECK(error([&] { return unlink(name.c_str()); }) == EPERM);
        CHECK(error([&] { return chmod(name.c_str(), 0777); }) == EPERM);
        CHECK(error([&] { return truncate(name.c_str(), 0); }) == EPERM);
        CHECK(error([&] { return rename(name.c_str(), (name + "b").c_str()); }) == EPERM);
        CHECK(error([&] { return symlink("/", (name + "c").c_str()); }) == EPERM);
        CHECK(std::filesystem::file_size(name) == 4);
    }

    TEST_CASE("a writer makes, renames and removes files in its folder alone") {
        if (lacks_landlock()) {
            return;
        }
        const Places places;
        const Ending good = confined(places.writing(), [&] {
            const std::string part = places.base.file("out/.part");
            const std::string whole = places.base.file("out/whole");
            const int file = open(part.c_str(), O_RDWR | O_CREAT | O_EXCL, 0600);
            const bool written = file >= 0 && write(file, "x", 1) == 1 && fsync(file) == 0 &&
                                 ftruncate(file, 3) == 0;
            const bool renamed = rename(part.c_str(), whole.c_str()) == 0;
            const bool removed = unlink(places.base.file("out/old").c_str()) == 0;
            return written && renamed && removed ? 0 : errno;
        });
        CHECK(good.code == 0);
        CHECK(std::filesystem::file_size(places.base.file("out/whole")) == 3);
        CHECK(!std::filesystem::exists(places.base.file("out/old")));
        CHECK(places.opened(places.writing(), "private/new", O_WRONLY | O_CREAT) == EACCES);
        CHECK(places.opened(places.writing(), "in/a") == EACCES);
        const Ending moved = confined(places.writing(), [&] {
            return error_of_call(rename(places.base.file("private/secret").c_str(),
                                        places.base.file("out/secret").c_str()));
        });
        CHECK(moved.code != 0);
        CHECK(std::filesystem::exists(places.base.file("private/secret")));
    }

    TEST_CASE("a thread of a library, which blocks all signals, is confined, too") {
        if (lacks_landlock()) {
            return;
        }
        const Ending ending = in_child([] {
            std::atomic<int> step{0}, error{-1};
            std::thread library([&] {
                sigset_t all;
                sigfillset(&all);
                pthread_sigmask(SIG_BLOCK, &all, nullptr);
                step = 1;
                step.notify_all();
                step.wait(1);
                error = error_of_open("/etc/passwd");
            });
            step.wait(0);
            restrict_files({});
            step = 2;
            step.notify_all();
            library.join();
            return error.load();
        });
        CHECK(ending.code == EACCES);
    }

    TEST_CASE("a file does not grow beyond the limit") {
        if (lacks_sandbox()) {
            return;
        }
        const Places places;
        const auto write_all = [&](std::uint64_t bytes) {
            return confined(places.writing(), [&] {
                std::signal(SIGXFSZ, SIG_IGN);  // As the io process does.
                const int file =
                    open(places.base.file("out/new").c_str(), O_WRONLY | O_CREAT, 0600);
                return error_of_call(pwrite(file, "x", 1, static_cast<off_t>(bytes - 1)));
            });
        };
        CHECK(write_all(small_file).code == 0);
        CHECK(write_all(small_file + 1).code == EFBIG);
    }

    TEST_CASE("limits cannot be raised again, and no core file is written") {
        if (lacks_sandbox()) {
            return;
        }
        const Ending ending = confined({}, [] {
            rlimit core{}, files{};
            getrlimit(RLIMIT_CORE, &core);
            getrlimit(RLIMIT_NOFILE, &files);
            const bool low = core.rlim_max == 0 && files.rlim_max <= 128;
            const rlimit less{files.rlim_max, files.rlim_max};
            return low && setrlimit(RLIMIT_NOFILE, &less) != 0 ? 0 : 1;
        });
        CHECK(ending.code == 0);
    }

    TEST_CASE("what a kernel lacks is named with its consequence and the remedy") {
        CHECK(missing_protections(1, true).empty());
        const auto missing = missing_protections(0, false);
        REQUIRE(missing.size() == 2);
        CHECK(missing[0].find("Landlock: pxpl5-io can open every file") == 0);
        CHECK(missing[0].find("lsm=") != std::string::npos);
        CHECK(missing[1].find("seccomp filters: pxpl5-io can start programs") == 0);
    }
}
