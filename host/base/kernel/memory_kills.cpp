#include "host/base/kernel/memory_kills.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace pxpl5::host {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view memory_controller = "memory";

/// A hierarchy of control groups that can count.
struct Hierarchy {
    std::string_view system;  ///< Type of its mount.
    const char* file;         ///< Has the count of a group.
};
constexpr Hierarchy version_1{"cgroup", "memory.oom_control"};
constexpr Hierarchy version_2{"cgroup2", "memory.events"};

bool has_word(const std::string& list, std::string_view word) {
    return ("," + list + ",").find("," + std::string(word) + ",") != std::string::npos;
}

/// The value of "oom_kill VALUE", one name and value per line.
std::optional<std::uint64_t> kills_in(const fs::path& path) {
    std::ifstream file(path);
    std::string name;
    for (std::uint64_t value = 0; file >> name >> value;) {
        if (name == "oom_kill") {
            return value;
        }
    }
    return std::nullopt;
}

/// The group of this process from lines as "4:memory:/user" and "0::/user". Empty if none.
std::string group_in(const fs::path& cgroup, const Hierarchy& hierarchy) {
    std::ifstream file(cgroup);
    for (std::string line; std::getline(file, line);) {
        const std::size_t first = line.find(':'), second = line.find(':', first + 1);
        if (first == std::string::npos || second == std::string::npos) {
            continue;
        }
        const std::string controllers = line.substr(first + 1, second - first - 1);
        if (hierarchy.system == version_2.system ? controllers.empty()
                                                 : has_word(controllers, memory_controller)) {
            return line.substr(second + 1);
        }
    }
    return "";
}

/// The folder of the group. In a container, the mounted folder may be the group itself.
fs::path folder_of(const fs::path& mounts, const std::string& group, const Hierarchy& hierarchy) {
    std::ifstream file(mounts);
    for (std::string line; std::getline(file, line);) {
        std::istringstream text(line);
        const std::vector<std::string> words{std::istream_iterator<std::string>(text), {}};
        const auto dash = std::find(words.begin(), words.end(), "-");
        constexpr std::size_t root_word = 3, place_word = 4;
        if (words.end() - dash < 4 || dash - words.begin() <= static_cast<long>(place_word) ||
            dash[1] != hierarchy.system ||
            (hierarchy.system == version_1.system && !has_word(dash[3], memory_controller))) {
            continue;
        }
        const fs::path place = fs::path(words[place_word]).relative_path();
        const fs::path within = fs::path(group).lexically_relative(words[root_word]);
        const bool is_beneath = !within.empty() && *within.begin() != "..";
        return is_beneath ? place / within : place;
    }
    return {};
}

}  // namespace

std::optional<MemoryKills> memory_kills(const fs::path& root) {
    const fs::path proc = root / "proc";
    for (const Hierarchy& hierarchy : {version_1, version_2}) {
        const std::string group = group_in(proc / "self/cgroup", hierarchy);
        const fs::path folder =
            group.empty() ? fs::path() : folder_of(proc / "self/mountinfo", group, hierarchy);
        if (!folder.empty()) {
            if (const auto count = kills_in(root / folder / hierarchy.file)) {
                return MemoryKills{*count, true};
            }
        }
    }
    const auto count = kills_in(proc / "vmstat");
    return count ? std::optional(MemoryKills{*count, false}) : std::nullopt;
}

}  // namespace pxpl5::host
