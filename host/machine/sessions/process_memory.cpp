#include "host/machine/sessions/process_memory.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

namespace pxpl5::host {

namespace {

namespace fs = std::filesystem;

/// Names in a folder of /proc, which may change or go meanwhile.
std::vector<std::string> names_in(const fs::path& folder) {
    std::vector<std::string> names;
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
        names.push_back(at->path().filename().string());
    }
    return names;
}

/// The parent in /proc/PID/stat; 0 if there is no such process.
pid_t parent_of(const std::string& pid) {
    std::ifstream file(fmt::format("/proc/{}/stat", pid));
    std::string line;
    std::getline(file, line);
    char state = '?';
    pid_t parent = 0;
    const std::size_t name_end = line.rfind(')');
    if (name_end != std::string::npos) {
        std::istringstream(line.substr(name_end + 1)) >> state >> parent;
    }
    return parent;
}

std::vector<pid_t> children_of(pid_t pid) {
    std::vector<pid_t> found;
    bool is_told = false;
    const std::string tasks = fmt::format("/proc/{}/task", pid);
    for (const std::string& thread : names_in(tasks)) {  // Each has the children that it started.
        std::ifstream children(tasks + "/" + thread + "/children");
        is_told = is_told || children.is_open();
        for (pid_t child = 0; children >> child;) {
            found.push_back(child);
        }
    }
    if (is_told) {
        return found;
    }
    for (const std::string& name : names_in("/proc")) {  // A kernel without CONFIG_PROC_CHILDREN.
        if (name.find_first_not_of("0123456789") == std::string::npos && parent_of(name) == pid) {
            found.push_back(std::stoi(name));
        }
    }
    return found;
}

/// Sums over the tree of processes. A process that ends meanwhile counts 0.
std::uint64_t sum_of_tree(pid_t root, const std::function<std::uint64_t(pid_t)>& bytes_of) {
    std::uint64_t bytes = bytes_of(root);
    for (const pid_t child : children_of(root)) {
        bytes += sum_of_tree(child, bytes_of);
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
