#include "host/base/part_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <system_error>
#include <utility>

namespace pxpl5::host {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t buffer_bytes = std::size_t{1} << 18;

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

PartFile::PartFile(fs::path target)
    : target_(std::move(target)),
      part_(target_.parent_path() /
            fmt::format(".{}.{}.part{}", target_.stem().string(), getpid(), suffix_of(target_))) {
    errno = 0;
    file_ = std::fopen(part_.c_str(), "wb");
    if (file_ == nullptr) {
        note_failure();
    } else {
        std::setvbuf(file_, nullptr, _IOFBF, buffer_bytes);
    }
}

PartFile::~PartFile() {
    if (file_ != nullptr) {
        std::fclose(file_);
    }
    std::error_code absent;
    fs::remove(part_, absent);
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
    if (failure_ != 0) {
        return std::generic_category().message(failure_);
    }
    std::error_code failure;
    fs::rename(part_, target_, failure);
    return failure ? failure.message() : "";
}

}  // namespace pxpl5::host
