#include "host/machine/sessions/process_memory.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>

namespace pxpl5::host {

namespace {

namespace fs = std::filesystem;

/// Sums over the tree of processes. A process that ends meanwhile counts 0.
std::uint64_t sum_of_tree(pid_t root, const std::function<std::uint64_t(pid_t)>& bytes_of) {
    std::uint64_t bytes = bytes_of(root);
    std::error_code ignored;
    // Each thread has the children that it has started.
    for (const fs::directory_entry& thread :
         fs::directory_iterator(fmt::format("/proc/{}/task", root), ignored)) {
        std::ifstream children(thread.path() / "children");
        for (pid_t child = 0; children >> child;) {
            bytes += sum_of_tree(child, bytes_of);
        }
    }
    return bytes;
}

}  // namespace

std::uint64_t proportional_bytes(pid_t root) {
    return sum_of_tree(root, [](pid_t pid) {
        constexpr std::uint64_t bytes_per_kib = 1024;
        std::ifstream file(fmt::format("/proc/{}/smaps_rollup", pid));
        for (std::string line; std::getline(file, line);) {
            std::uint64_t kib = 0;
            if (line.starts_with("Pss:") && std::istringstream(line.substr(4)) >> kib) {
                return kib * bytes_per_kib;
            }
        }
        return std::uint64_t{0};
    });
}

std::uint64_t resident_bytes(pid_t root) {
    const auto page = static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
    return sum_of_tree(root, [page](pid_t pid) {
        std::ifstream file(fmt::format("/proc/{}/statm", pid));
        std::uint64_t all = 0, resident = 0;
        file >> all >> resident;
        return resident * page;
    });
}

}  // namespace pxpl5::host
