#include "host/base/part_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <system_error>
#include <utility>

namespace pxpl5::host {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t buffer_bytes = std::size_t{1} << 18;

/// Characters that no other program can foresee.
std::string random_text() {
    std::uint64_t bits = 0;
    if (getrandom(&bits, sizeof bits, GRND_NONBLOCK) != sizeof bits) {
        static std::uint64_t count = 0;  // Early at boot: O_EXCL still keeps other files safe.
        bits = static_cast<std::uint64_t>(getpid()) << 32 | ++count;
    }
    return fmt::format("{:016x}", bits);
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

std::string missing_folder(const fs::path& path) {
    const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
    std::error_code unreadable;
    if (fs::is_directory(folder, unreadable)) {
        return "";
    }
    return fmt::format("{}: its folder {} does not exist", path.string(), folder.string());
}

namespace {

/// For remove_part_files(). More files than places: the others stay.
std::array<std::atomic<const char*>, 4> open_parts{};

}  // namespace

PartFile::PartFile(fs::path target)
    : target_(std::move(target)),
      part_(target_.parent_path() / fmt::format(".{}.{}.part{}", target_.stem().string(),
                                                random_text(), suffix_of(target_))) {
    errno = 0;
    const int fd =
        ::open(part_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    file_ = fd < 0 ? nullptr : fdopen(fd, "wb");
    if (file_ == nullptr) {
        note_failure();
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
    for (std::atomic<const char*>& place : open_parts) {
        const char* own = part_.c_str();
        place.compare_exchange_strong(own, nullptr);
    }
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

std::string PartFile::keep() {
    errno = 0;
    if (file_ != nullptr && std::fclose(std::exchange(file_, nullptr)) != 0) {
        note_failure();
    }
    if (failure_ == 0 && !is_synced(part_)) {
        note_failure();
    }
    if (failure_ != 0) {
        return std::generic_category().message(failure_);
    }
    std::error_code failure;
    fs::rename(part_, target_, failure);
    if (!failure) {
        // The file is there; a folder that cannot be read cannot be synced either.
        [[maybe_unused]] const bool synced =
            is_synced(target_.has_parent_path() ? target_.parent_path() : fs::path("."));
    }
    return failure ? failure.message() : "";
}

}  // namespace pxpl5::host
