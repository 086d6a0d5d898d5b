#include "host/io/sandbox/sandbox.hpp"

#include <sys/prctl.h>
#include <sys/resource.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "host/io/sandbox/sanitizer.hpp"

namespace pxpl5::host::io {

namespace {

constexpr rlim_t max_descriptors = 128;
constexpr rlim_t log_bytes = rlim_t{1} << 20;
/// Seconds from SIGXCPU, which a process can ignore, to SIGKILL.
constexpr rlim_t grace_s = 1;

/// Lowers a limit for good.
void limit(__rlimit_resource resource, rlim_t most) {
    rlimit now{};
    getrlimit(resource, &now);
    now.rlim_max = std::min(now.rlim_max, most);
    now.rlim_cur = std::min(now.rlim_cur, now.rlim_max);
    if (setrlimit(resource, &now) != 0) {
        throw std::system_error(errno, std::generic_category(), "cannot lower a limit");
    }
}

/// The soft limit that limit_memory() or limit_next_request() has set.
rlim_t soft(__rlimit_resource resource) {
    rlimit now{};
    getrlimit(resource, &now);
    return now.rlim_cur;
}

void limit_resources(const Needs& needs) {
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_NOFILE, max_descriptors);
    limit(RLIMIT_FSIZE, std::max(log_bytes, rlim_t{needs.file_bytes}));
    limit(RLIMIT_AS, soft(RLIMIT_AS));
    if (const rlim_t cpu_s = soft(RLIMIT_CPU); cpu_s != RLIM_INFINITY) {
        limit(RLIMIT_CPU, cpu_s + grace_s);
    }
}

}  // namespace

void confine(const Needs& needs) {
    if (has_sanitizer) {
        return;
    }
    limit_resources(needs);
    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    restrict_files(needs.files);
    restrict_system_calls(needs.task);
}

}  // namespace pxpl5::host::io
