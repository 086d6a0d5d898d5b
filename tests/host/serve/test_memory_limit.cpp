#include <doctest/doctest.h>

#include <cstdint>
#include <string>

#include "host/serve/limits/memory_limit.hpp"
#include "tests/host/serve/scratch_folder.hpp"

using namespace pxpl5::host::serve;

namespace {

constexpr std::uint64_t mib = 1 << 20;

}  // namespace

TEST_CASE("free memory is what the computer has, unless a control group allows less") {
    const ScratchFolder root;
    root.write("proc/meminfo", "MemTotal:  999999 kB\nMemAvailable:   102400 kB\n");
    root.write("proc/self/cgroup", "0::/user/job\n");
    CHECK(free_memory(root.path) == 100 * mib);
    const auto group = [&](const std::string& name, const std::string& most, std::uint64_t used) {
        root.write("sys/fs/cgroup/" + name + "/memory.max", most + "\n");
        root.write("sys/fs/cgroup/" + name + "/memory.current", std::to_string(used) + "\n");
    };
    group("user/job", "max", 5 * mib);
    CHECK(free_memory(root.path) == 100 * mib);
    group("user/job", std::to_string(60 * mib), 20 * mib);
    CHECK(free_memory(root.path) == 40 * mib);
    group("user", std::to_string(70 * mib), 45 * mib);  // Around the job.
    CHECK(free_memory(root.path) == 25 * mib);
    group("user/job", std::to_string(60 * mib), 61 * mib);
    CHECK(free_memory(root.path) == 0);
}

TEST_CASE("free memory is unknown on a computer that does not tell") {
    const ScratchFolder empty;
    CHECK(!free_memory(empty.path));
}

TEST_CASE("amounts of memory have three digits") {
    CHECK(gib_text(std::uint64_t{4} << 30) == "4 GiB");
    CHECK(gib_text(18 * mib) == "0.0176 GiB");
}
