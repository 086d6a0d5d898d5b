#include "host/base/kernel/control_groups.hpp"

#include <fstream>

namespace pxpl5::host {

namespace {

namespace fs = std::filesystem;

/// The number in a file of a control group. Empty for "max", and if the file does not exist.
std::optional<std::uint64_t> number_in(const fs::path& path) {
    std::ifstream file(path);
    std::uint64_t number = 0;
    return file >> number ? std::optional(number) : std::nullopt;
}

/// Keeps in `least` the tighter of `least` and the limits of `group` and of the groups around it.
/// In a container, a group may have a path that is not mounted.
void note_groups(const std::string& controller, const fs::path& mount, fs::path group,
                 std::optional<GroupLimit>& least) {
    for (bool is_root = false; !is_root; group = group.parent_path()) {
        is_root = group.empty();
        const fs::path folder = is_root ? mount : mount / group;
        const auto most = number_in(folder / (controller + ".max"));
        const auto used = number_in(folder / (controller + ".current"));
        if (most && used) {
            const GroupLimit limit{folder / (controller + ".max"), *most, *used};
            if (!least || limit.left() < least->left()) {
                least = limit;
            }
        }
    }
}

}  // namespace

std::optional<GroupLimit> tightest_group_limit(const std::string& controller,
                                               const fs::path& root) {
    std::ifstream file(root / "proc/self/cgroup");
    const fs::path mount = root / "sys/fs/cgroup";
    std::optional<GroupLimit> least;
    // Lines are "4:pids:/group" in version 1 and "0::/group" in version 2.
    for (std::string line; std::getline(file, line);) {
        const std::size_t first = line.find(':'), second = line.find(':', first + 1);
        if (first == std::string::npos || second == std::string::npos) {
            continue;
        }
        const std::string controllers = line.substr(first + 1, second - first - 1);
        const fs::path group = fs::path(line.substr(second + 1)).relative_path();
        if (controllers.empty() || controllers == controller) {
            note_groups(controller, mount / controllers, group, least);
        }
    }
    return least;
}

}  // namespace pxpl5::host
