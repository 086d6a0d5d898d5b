#include "host/base/kernel/locked_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <system_error>
#include <vector>

#include "host/base/kernel/owned_descriptor.hpp"

namespace pxpl5::host {

namespace {

namespace fs = std::filesystem;

std::vector<fs::path> entries_of(const fs::path& folder) {
    std::vector<fs::path> entries;
    std::error_code failure;
    for (fs::directory_iterator at(folder, failure); !failure && at != fs::directory_iterator();
         at.increment(failure)) {
        entries.push_back(at->path());
    }
    return entries;
}

/// Removes the folder `path`; `contents` is the same folder, perhaps by another path. The lock file
/// is last: if this process is killed, a later start removes the rest.
void remove_folder(const fs::path& path, const fs::path& contents) {
    std::error_code failure;
    bool is_bare = true;
    for (const fs::path& entry : entries_of(contents)) {
        if (entry.filename() != temporary_lock) {
            fs::remove_all(entry, failure);
            is_bare = is_bare && !failure;
        }
    }
    if (is_bare) {
        ::unlink((contents / temporary_lock).c_str());
        ::rmdir(path.c_str());
    }
}

bool is_same_file(int file, const fs::path& path) {
    struct stat own {};
    struct stat there {};
    return fstat(file, &own) == 0 && lstat(path.c_str(), &there) == 0 &&
           own.st_dev == there.st_dev && own.st_ino == there.st_ino;
}

struct NewLock {
    int file = -1;         ///< Negative: the file system has no locks.
    bool is_lost = false;  ///< Another start has removed the folder, or does so now.
    int reason = 0;        ///< The errno if the file cannot be made.
};

/// Locks a new folder. If this process was stopped for long in between, another start takes the
/// folder for a stale one.
NewLock lock_new_folder(const fs::path& folder) {
    const fs::path lock = folder / temporary_lock;
    const int file = ::open(lock.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
    if (file < 0) {
        return {.is_lost = errno == ENOENT, .reason = errno};
    }
    const bool is_locked = flock(file, LOCK_EX | LOCK_NB) == 0;
    const bool is_lost = is_locked ? !is_same_file(file, lock) : errno == EWOULDBLOCK;
    if (is_locked && !is_lost) {
        return {.file = file};
    }
    if (!is_lost) {
        ::unlink(lock.c_str());
    }
    ::close(file);
    return {.is_lost = is_lost};
}

bool is_lock_file(int file) {
    struct stat facts {};
    return fstat(file, &facts) == 0 && S_ISREG(facts.st_mode) && facts.st_size == 0 &&
           facts.st_uid == geteuid();
}

/// Removes the folder if no program has locked it and `is_unused` agrees.
void remove_if_unused(const fs::path& path, const IsUnused& is_unused) {
    // Others may write to the parent: only what lies in a folder of this user is removed, also if
    // another user puts a link in its place meanwhile.
    const OwnedDescriptor folder(
        ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    struct stat facts {};
    if (folder.fd < 0 || fstat(folder.fd, &facts) != 0 || facts.st_uid != geteuid()) {
        return;
    }
    const OwnedDescriptor lock(
        openat(folder.fd, temporary_lock, O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
    const bool has_lock = lock.fd >= 0;
    const bool is_free = has_lock ? is_lock_file(lock.fd) && flock(lock.fd, LOCK_EX | LOCK_NB) == 0
                                  : errno == ENOENT;
    if (is_free && is_unused(path, has_lock)) {
        remove_folder(path, fmt::format("/proc/self/fd/{}", folder.fd));
    }
}

}  // namespace

bool is_stale_folder(const fs::path& folder, std::string_view begin, std::chrono::seconds youth) {
    constexpr std::size_t random_letters = 6;
    const std::string name = folder.filename().string();
    struct stat facts {};
    return name.starts_with(begin) && name.size() == begin.size() + random_letters &&
           lstat(folder.c_str(), &facts) == 0 && S_ISDIR(facts.st_mode) &&
           facts.st_uid == geteuid() && (facts.st_mode & ACCESSPERMS) == S_IRWXU &&
           std::time(nullptr) - facts.st_mtime >= youth.count();
}

int LockedFolder::make(const fs::path& parent, const std::string& name) {
    for (;;) {
        std::string pattern = parent / (name + "-XXXXXX");
        if (mkdtemp(pattern.data()) == nullptr) {
            return errno;
        }
        const NewLock lock = lock_new_folder(pattern);
        if (lock.is_lost) {
            continue;
        }
        if (lock.reason != 0) {
            ::rmdir(pattern.c_str());
            return lock.reason;
        }
        path_ = pattern;
        lock_ = lock.file;
        return 0;
    }
}

LockedFolder::~LockedFolder() {
    if (!path_.empty()) {
        remove_folder(path_, path_);
    }
    if (lock_ >= 0) {
        ::close(lock_);
    }
}

void remove_stale_folders(const fs::path& parent, std::span<const std::string_view> begins,
                          const IsUnused& is_unused) {
    for (const fs::path& path : entries_of(parent)) {
        if (std::ranges::any_of(
                begins, [&](std::string_view begin) { return is_stale_folder(path, begin); })) {
            remove_if_unused(path, is_unused);
        }
    }
}

}  // namespace pxpl5::host
