#include "host/io/sandbox/file_rules.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/landlock.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "host/base/kernel/protections.hpp"
#include "host/io/sandbox/every_thread.hpp"

namespace pxpl5::host::io {

namespace {

// Rights and fields that are newer than the headers of Debian 12.
constexpr std::uint64_t access_truncate = 1U << 14, access_ioctl_dev = 1U << 15;
constexpr std::uint64_t net_bind_tcp = 1U << 0, net_connect_tcp = 1U << 1;
constexpr std::uint64_t scope_abstract_sockets = 1U << 0, scope_signals = 1U << 1;
constexpr int version_refer = 2, version_truncate = 3, version_net = 4, version_ioctl = 5,
              version_scope = 6;

constexpr std::uint64_t access_read = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;
constexpr std::uint64_t access_write = access_read | access_truncate |
                                       LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_MAKE_REG |
                                       LANDLOCK_ACCESS_FS_REMOVE_FILE;
/// Rights that a rule for one file may have.
constexpr std::uint64_t access_of_file =
    LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_WRITE_FILE | access_truncate;

/// struct landlock_ruleset_attr of version 6. Older kernels take its first fields.
struct RulesetFields {
    std::uint64_t access_fs = 0, access_net = 0, scoped = 0;
};

/// Everything that this version of Landlock can refuse.
RulesetFields fields_of(int version) {
    RulesetFields fields;
    fields.access_fs = (LANDLOCK_ACCESS_FS_MAKE_SYM << 1) - 1;
    fields.access_fs |= version >= version_refer ? LANDLOCK_ACCESS_FS_REFER : 0;
    fields.access_fs |= version >= version_truncate ? access_truncate : 0;
    fields.access_fs |= version >= version_ioctl ? access_ioctl_dev : 0;
    fields.access_net = version >= version_net ? net_bind_tcp | net_connect_tcp : 0;
    fields.scoped = version >= version_scope ? scope_abstract_sockets | scope_signals : 0;
    return fields;
}

std::size_t size_of_fields(int version) {
    return sizeof(std::uint64_t) * (version >= version_scope ? 3 : version >= version_net ? 2 : 1);
}

[[noreturn]] void refuse(const std::string& what) {
    throw std::runtime_error(fmt::format("Landlock: {}: {}", what, std::strerror(errno)));
}

/// A set of rules that is not in force yet.
class Ruleset {
  public:
    explicit Ruleset(int version)
        : fields_(fields_of(version)),
          fd_(static_cast<int>(
              syscall(SYS_landlock_create_ruleset, &fields_, size_of_fields(version), 0))) {
        if (fd_ < 0) {
            refuse("cannot make rules");
        }
    }
    ~Ruleset() { close(fd_); }
    Ruleset(const Ruleset&) = delete;
    Ruleset& operator=(const Ruleset&) = delete;

    int fd() const { return fd_; }

    void allow(const std::filesystem::path& path, std::uint64_t access) const {
        const int place = open(path.c_str(), O_PATH | O_CLOEXEC);
        struct stat facts {};
        if (place < 0 || fstat(place, &facts) != 0) {
            return;  // The request then reports the missing file.
        }
        landlock_path_beneath_attr rule{};
        rule.allowed_access =
            fields_.access_fs & access & (S_ISDIR(facts.st_mode) ? ~0ULL : access_of_file);
        rule.parent_fd = place;
        const long failed =
            rule.allowed_access == 0
                ? 0
                : syscall(SYS_landlock_add_rule, fd_, LANDLOCK_RULE_PATH_BENEATH, &rule, 0);
        const int reason = errno;
        close(place);
        errno = reason;
        if (failed != 0) {
            refuse("cannot allow " + path.string());
        }
    }

  private:
    RulesetFields fields_;
    int fd_;
};

/// The rules that each thread puts into force. A signal handler sees only static variables.
std::atomic<int> ruleset_in_force{-1};

bool restrict_this_thread() {
    return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
           syscall(SYS_landlock_restrict_self, ruleset_in_force.load(), 0) == 0;
}

}  // namespace

bool restrict_files(const FileRules& rules) {
    const int version = landlock_version();
    if (version == 0) {
        return false;
    }
    const Ruleset ruleset(version);
    for (const auto& path : rules.readable) {
        ruleset.allow(path, access_read);
    }
    for (const auto& path : rules.listed) {
        ruleset.allow(path, LANDLOCK_ACCESS_FS_READ_DIR);
    }
    for (const auto& path : rules.writable) {
        ruleset.allow(path, access_write);
    }
    ruleset_in_force = ruleset.fd();
    in_every_thread(&restrict_this_thread);
    return true;
}

}  // namespace pxpl5::host::io
