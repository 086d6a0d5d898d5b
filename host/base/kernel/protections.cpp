#include "host/base/kernel/protections.hpp"

#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>

namespace pxpl5::host {

int landlock_version() {
    const long version =
        syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
    return static_cast<int>(std::max(version, 0L));
}

bool has_system_call_filters() {
    const unsigned action = SECCOMP_RET_TRAP;
    return syscall(SYS_seccomp, SECCOMP_GET_ACTION_AVAIL, 0, &action) == 0;
}

std::vector<std::string> missing_protections(int landlock, bool has_filters) {
    std::vector<std::string> missing;
    if (landlock == 0) {
        missing.emplace_back(
            "Landlock: pxpl5-io can open every file of this user. Use Linux 5.13 or later, with "
            "landlock in the list of the boot option lsm=");
    }
    if (!has_filters) {
        missing.emplace_back(
            "seccomp filters: pxpl5-io can start programs and open connections. Use a kernel with "
            "CONFIG_SECCOMP_FILTER, and a container that lets programs set filters");
    }
    return missing;
}

}  // namespace pxpl5::host
