#include "host/base/kernel/thread_limits.hpp"

#include <doctest/doctest.h>
#include <stdlib.h>

#include <fstream>

using namespace pxpl5::host;
namespace fs = std::filesystem;

namespace {

/// A folder with files as those in /proc and /sys.
struct System {
    fs::path root;

    System() {
        std::string name = (fs::temp_directory_path() / "pxpl5-test-XXXXXX").string();
        REQUIRE(mkdtemp(name.data()) != nullptr);
        root = name;
    }
    ~System() { fs::remove_all(root); }
    System(const System&) = delete;
    System& operator=(const System&) = delete;

    void write(const std::string& path, const std::string& text) const {
        fs::create_directories((root / path).parent_path());
        std::ofstream(root / path) << text;
    }
    void group(const std::string& path, const std::string& most, int used) const {
        write("sys/fs/cgroup/" + path + "pids.max", most + "\n");
        write("sys/fs/cgroup/" + path + "pids.current", std::to_string(used) + "\n");
    }
};

}  // namespace

TEST_SUITE("host/base/thread_limits") {
    TEST_CASE("the control group that leaves the fewest threads counts, in both versions") {
        for (const std::string controller : {"", "pids"}) {
            const System system;
            const std::string folder = controller.empty() ? "" : controller + "/";
            system.write(
                "proc/self/cgroup",
                "9:cpu:/\n" + (controller.empty() ? "0:" : "4:" + controller) + ":/user/session\n");
            CHECK(!group_thread_limit(system.root));
            system.group(folder + "user/session/", "max", 7);
            CHECK(!group_thread_limit(system.root));
            system.group(folder + "user/", "100", 90);
            system.group(folder, "50", 20);
            const auto limit = group_thread_limit(system.root);
            REQUIRE(limit.has_value());
            CHECK(limit->most == 100);
            CHECK(limit->used == 90);
            CHECK(limit->left() == 10);
            CHECK(limit->name.find("user/pids.max") != std::string::npos);
            system.group(folder + "user/session/", "5", 7);
            CHECK(group_thread_limit(system.root)->left() == 0);
        }
    }

    TEST_CASE("in a container whose group has another path, the mounted group counts") {
        const System system;
        system.write("proc/self/cgroup", "0::/docker/0123\n");
        system.group("", "30", 12);
        REQUIRE(group_thread_limit(system.root).has_value());
        CHECK(group_thread_limit(system.root)->left() == 18);
    }

    TEST_CASE("a system without control groups has no limit") {
        const System system;
        CHECK(!group_thread_limit(system.root));
        system.write("proc/self/cgroup", "damaged\n:\n");
        CHECK(!group_thread_limit(system.root));
    }

    TEST_CASE("the threads of a user are those of all processes with this real user") {
        const System system;
        system.write("proc/12/status", "Name:\ta\nUid:\t1000\t0\t0\t0\nThreads:\t4\n");
        system.write("proc/13/status", "Name:\tb\nUid:\t1000\t1000\t1000\t1000\nThreads:\t11\n");
        system.write("proc/14/status", "Name:\tc\nUid:\t0\t1000\t1000\t1000\nThreads:\t100\n");
        system.write("proc/version", "Linux\n");
        system.write("proc/15/comm", "ended\n");
        CHECK(threads_of_user(1000, system.root) == 15);
        CHECK(threads_of_user(0, system.root) == 100);
    }
}
