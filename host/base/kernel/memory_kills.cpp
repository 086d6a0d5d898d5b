#include "host/base/kernel/memory_kills.hpp"

#include <fstream>
#include <string>

namespace pxpl5::host {

std::optional<std::uint64_t> memory_kills_in(std::istream& vmstat) {
    std::string name;
    for (std::uint64_t value = 0; vmstat >> name >> value;) {
        if (name == "oom_kill") {
            return value;
        }
    }
    return std::nullopt;
}

std::optional<std::uint64_t> memory_kills() {
    std::ifstream vmstat("/proc/vmstat");
    return memory_kills_in(vmstat);
}

}  // namespace pxpl5::host
