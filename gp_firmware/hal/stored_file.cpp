#include "gp_firmware/hal/stored_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace pxpl5::gp {

namespace {

/// The host reads no file above max_volume_bytes.
[[noreturn]] void fail(const std::string& path, const FileFacts& stated,
                       const std::string& reason) {
    throw StoredFileError(
        path + ": " + reason +
        ". All computers must see the same unchanged file under this path. Load it again" +
        (stated.size_bytes <= max_volume_bytes ? ", or with read=host" : ""));
}

template <class Value>
std::string difference(const char* what, Value here, Value stated) {
    return std::string(what) + " is " + std::to_string(here) + " here, but was " +
           std::to_string(stated) + " when the host loaded the volume";
}

}  // namespace

StoredFile::StoredFile(const std::string& path, const FileFacts& stated)
    : path_(path), stated_(stated) {
    // O_NONBLOCK: a FIFO without a writer would block here for ever.
    file_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (file_ < 0) {
        fail(path, stated, std::string("cannot be opened: ") + std::strerror(errno));
    }
    try {
        check();
    } catch (...) {
        ::close(file_);
        throw;
    }
}

StoredFile::~StoredFile() {
    ::close(file_);
}

void StoredFile::check() const {
    constexpr std::int64_t ns_per_s = 1'000'000'000;
    struct stat here {};
    if (::fstat(file_, &here) != 0 || !S_ISREG(here.st_mode)) {
        fail(path_, stated_, "is no regular file");
    }
    const auto compare = [&](const char* what, auto now, decltype(now) stated) {
        if (now != stated) {
            fail(path_, stated_, difference(what, now, stated));
        }
    };
    compare("its size in bytes", static_cast<std::uint64_t>(here.st_size), stated_.size_bytes);
    compare("its inode", std::uint64_t{here.st_ino}, stated_.inode);
    compare("the time of its last change in ns",
            std::int64_t{here.st_mtim.tv_sec} * ns_per_s + here.st_mtim.tv_nsec,
            stated_.modified_ns);
}

void StoredFile::read(std::uint64_t offset_bytes, std::span<std::byte> out) const {
    for (std::size_t done = 0; done < out.size();) {
        const ssize_t came = ::pread(file_, out.data() + done, out.size() - done,
                                     static_cast<off_t>(offset_bytes + done));
        if (came < 0 && errno == EINTR) {
            continue;
        }
        if (came <= 0) {
            fail(path_, stated_,
                 "cannot be read at byte " + std::to_string(offset_bytes + done) + ": " +
                     (came < 0 ? std::strerror(errno) : "the file ends"));
        }
        done += static_cast<std::size_t>(came);
    }
}

std::string computer_name() {
    std::array<char, 256> name{};
    return ::gethostname(name.data(), name.size() - 1) == 0 && name[0] != '\0'
               ? name.data()
               : "an unknown computer";
}

}  // namespace pxpl5::gp
