#include "host/base/part_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/magic.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <sys/statfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <functional>
#include <mutex>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include "host/base/kernel/owned_descriptor.hpp"

namespace pxpl5::host {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t buffer_bytes = std::size_t{1} << 18;
constexpr std::size_t random_digits = 16;
constexpr std::string_view part_end = ".part";
constexpr std::size_t mark_size = 1 + random_digits + part_end.size();  // ".RANDOM.part"

/// Characters that no other program can foresee.
std::string random_text() {
    std::uint64_t bits = 0;
    if (getrandom(&bits, sizeof bits, GRND_NONBLOCK) != sizeof bits) {
        static std::uint64_t count = 0;  // Early at boot: O_EXCL still keeps other files safe.
        bits = static_cast<std::uint64_t>(getpid()) << 32 | ++count;
    }
    return fmt::format("{:0{}x}", bits, random_digits);
}

/// Returns once the file or folder is on the disk. False and errno if it is not.
bool is_synced(const fs::path& path) {
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    // A file system that cannot sync a folder says EINVAL.
    const bool done = fd >= 0 && (fsync(fd) == 0 || errno == EINVAL || errno == EROFS);
    const int reason = errno;
    if (fd >= 0) {
        ::close(fd);
    }
    errno = reason;
    return done;
}

}  // namespace

std::string suffix_of(const fs::path& path) {
    std::string suffix = path.extension().string();
    std::transform(suffix.begin(), suffix.end(), suffix.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return suffix;
}

fs::path color_file_of(const fs::path& mesh) {
    return suffix_of(mesh) == ".obj" ? fs::path(mesh).replace_extension(".mtl") : fs::path();
}

namespace {

constexpr int max_links = 40;  // As in the kernel.

fs::path folder_of(const fs::path& path) {
    return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

/// The rule of the kernel (fs.protected_symlinks), which does not see that a link is followed
/// here.
bool may_follow(const fs::path& link) {
    struct stat own {};
    struct stat folder {};
    if (lstat(link.c_str(), &own) != 0 || stat(folder_of(link).c_str(), &folder) != 0) {
        return false;
    }
    const bool is_shared = (folder.st_mode & S_ISVTX) != 0 && (folder.st_mode & S_IWOTH) != 0;
    return !is_shared || own.st_uid == geteuid() || own.st_uid == folder.st_uid;
}

const char* kind_of(fs::file_type type) {
    switch (type) {
        case fs::file_type::directory:
            return "a folder";
        case fs::file_type::fifo:
            return "a FIFO";
        case fs::file_type::socket:
            return "a socket";
        default:
            return "a device";
    }
}

}  // namespace

fs::path place_of(const fs::path& path) {
    fs::path place = path;
    std::error_code failure;
    for (int links = 0; links < max_links && fs::is_symlink(place, failure); ++links) {
        if (!may_follow(place)) {
            return place;
        }
        const fs::path target = fs::read_symlink(place, failure);
        if (failure) {
            return place;
        }
        place = place.parent_path() / target;  // An absolute target replaces the folder.
    }
    return place;
}

std::string wrong_place(const fs::path& path) {
    const fs::path place = place_of(path), folder = folder_of(place);
    std::error_code unreadable;
    if (!fs::is_directory(folder, unreadable)) {
        return fmt::format("{}: its folder {} does not exist", path.string(), folder.string());
    }
    const fs::file_status there = fs::symlink_status(place, unreadable);
    if (fs::exists(there) && !fs::is_regular_file(there) && !fs::is_symlink(there)) {
        return fmt::format("{}: is {}, not a file: give the name of a file{}", path.string(),
                           kind_of(there.type()), fs::is_directory(there) ? " in it" : "");
    }
    return "";
}

bool is_of_kernel(const fs::path& path) {
    struct statfs system {};
    if (statfs(path.c_str(), &system) != 0) {
        return false;
    }
    constexpr std::array<std::uint64_t, 4> kinds = {PROC_SUPER_MAGIC, SYSFS_MAGIC, DEBUGFS_MAGIC,
                                                    TRACEFS_MAGIC};
    return std::ranges::find(kinds, static_cast<std::uint64_t>(system.f_type)) != kinds.end();
}

std::string why_unreadable(const fs::path& path) {
    std::error_code failure;
    const fs::file_status there = fs::status(path, failure);
    if (there.type() == fs::file_type::not_found) {
        return "does not exist";
    }
    if (fs::status_known(there) && !fs::is_regular_file(there)) {
        return fmt::format("is {}, not a file", kind_of(there.type()));
    }
    if (is_of_kernel(path)) {
        return "is a file of the kernel, not a stored file";
    }
    const int fd = failure ? -1 : ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    const int reason = failure ? failure.value() : errno;
    if (fd < 0) {
        return "cannot be opened: " + std::generic_category().message(reason);
    }
    ::close(fd);
    return "";
}

namespace {

/// For remove_part_files(). More files than places: the others stay.
std::array<std::atomic<const char*>, 4> open_parts{};

}  // namespace

PartFile::PartFile(const fs::path& target)
    : target_(place_of(target)),
      part_(target_.parent_path() / fmt::format(".{}.{}.part{}", target_.stem().string(),
                                                random_text(), suffix_of(target))) {
    errno = 0;
    const int fd =
        ::open(part_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    file_ = fd < 0 ? nullptr : fdopen(fd, "wb");
    if (fd >= 0 && flock(fd, LOCK_EX | LOCK_NB) == 0) {
        lock_ = fcntl(fd, F_DUPFD_CLOEXEC, 0);  // It keeps the lock while a library has the file.
    }
    if (file_ == nullptr) {
        note_failure();
        if (fd >= 0) {
            ::close(fd);
        }
    } else {
        for (std::atomic<const char*>& place : open_parts) {
            const char* none = nullptr;
            if (place.compare_exchange_strong(none, part_.c_str())) {
                break;
            }
        }
        std::setvbuf(file_, nullptr, _IOFBF, buffer_bytes);
    }
}

PartFile::~PartFile() {
    if (file_ != nullptr) {
        std::fclose(file_);
    }
    std::error_code absent;
    fs::remove(part_, absent);
    if (lock_ >= 0) {
        ::close(lock_);
    }
    for (std::atomic<const char*>& place : open_parts) {
        const char* own = part_.c_str();
        place.compare_exchange_strong(own, nullptr);
    }
}

namespace {

/// Returns whether `text` is ".RANDOM.part", as a PartFile has it between stem and suffix.
bool is_mark(std::string_view text) {
    return text.size() == mark_size && text.starts_with('.') && text.ends_with(part_end) &&
           std::ranges::all_of(text.substr(1, random_digits),
                               [](unsigned char c) { return std::isxdigit(c) != 0; });
}

void visit_files(const fs::path& folder, const std::function<void(const fs::path&)>& visit) {
    std::error_code failure;
    for (fs::directory_iterator at(folder, failure); !failure && at != fs::directory_iterator();
         at.increment(failure)) {
        std::error_code unknown;
        if (fs::is_regular_file(at->symlink_status(unknown))) {
            visit(at->path());
        }
    }
}

}  // namespace

void remove_parts_of(const fs::path& target, fs::file_time_type since) {
    const fs::path place = place_of(target);
    const std::string begin = "." + place.stem().string();
    const std::string end = place.extension().string();
    const bool has_colors = end == ".obj";  // Beside it, in a file of their own.
    visit_files(folder_of(place), [&](const fs::path& file) {
        const std::string name = file.filename().string();
        const bool is_part = name.starts_with(begin) &&
                             (name.ends_with(end) || (has_colors && name.ends_with(".mtl"))) &&
                             name.size() == begin.size() + mark_size + end.size() &&
                             is_mark(std::string_view(name).substr(begin.size(), mark_size));
        std::error_code unknown;
        if (is_part && fs::last_write_time(file, unknown) >= since && !unknown) {
            fs::remove(file, unknown);
        }
    });
}

void remove_abandoned_parts(const fs::path& target) {
    static std::mutex one_at_a_time;
    static std::set<fs::path> seen;
    const fs::path folder = folder_of(place_of(target));
    std::error_code unknown;
    {
        const std::lock_guard lock(one_at_a_time);
        if (!seen.insert(fs::absolute(folder, unknown)).second) {
            return;
        }
    }
    // A new file is not locked at once.
    const auto newest = fs::file_time_type::clock::now() - std::chrono::minutes(1);
    visit_files(folder, [newest](const fs::path& part) {
        const bool has_suffix = part.extension() != part_end;
        const std::string stem = (has_suffix ? part.stem() : part.filename()).string();
        if (!stem.starts_with('.') || stem.size() <= mark_size ||
            !is_mark(std::string_view(stem).substr(stem.size() - mark_size))) {
            return;
        }
        const OwnedDescriptor file(
            ::open(part.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
        struct stat facts {};
        std::error_code failure;
        if (file.fd >= 0 && fstat(file.fd, &facts) == 0 && facts.st_uid == geteuid() &&
            fs::last_write_time(part, failure) < newest && !failure &&
            flock(file.fd, LOCK_EX | LOCK_NB) == 0) {
            fs::remove(part, failure);
        }
    });
}

void remove_part_files() {
    for (const std::atomic<const char*>& place : open_parts) {
        if (const char* name = place.load(); name != nullptr) {
            ::unlink(name);
        }
    }
}

void PartFile::note_failure() {
    if (failure_ == 0) {
        failure_ = errno != 0 ? errno : EIO;
    }
}

void PartFile::write(std::string_view bytes) {
    if (failure_ != 0) {
        return;
    }
    errno = 0;
    if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) {
        note_failure();
    }
}

std::string PartFile::lack_of_room(std::uint64_t bytes) const {
    const int failure =
        file_ == nullptr ? failure_ : posix_fallocate(fileno(file_), 0, static_cast<off_t>(bytes));
    const bool is_lack = failure == ENOSPC || failure == EFBIG || failure == EDQUOT;
    return is_lack ? std::generic_category().message(failure) : "";
}

std::string PartFile::finish() {
    errno = 0;
    if (file_ != nullptr) {
        if (std::ferror(file_) != 0) {
            note_failure();  // A library has written, and the reason is lost.
        }
        if (std::fclose(std::exchange(file_, nullptr)) != 0) {
            note_failure();
        }
        if (failure_ == 0 && !is_synced(part_)) {
            note_failure();
        }
    }
    return failure_ == 0 ? "" : std::generic_category().message(failure_);
}

std::string PartFile::keep() {
    if (std::string reason = finish(); !reason.empty()) {
        return reason;
    }
    std::error_code failure;
    fs::rename(part_, target_, failure);
    if (!failure) {
        // The file is there; a folder that cannot be read cannot be synced either.
        [[maybe_unused]] const bool synced = is_synced(folder_of(target_));
    }
    return failure ? failure.message() : "";
}

}  // namespace pxpl5::host
