#include "host/io/formats/data_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/openat2.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "host/io/values/file_facts.hpp"
#include "host/io/values/import_request.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

/// O_NONBLOCK: a FIFO without a writer would block here for ever.
constexpr int flags = O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY;

/// Opens `name` in `folder` or below; links and ".." must not lead out. -1 and errno on failure.
int open_beneath(const fs::path& folder, const std::string& name) {
    const int at = ::open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
    if (at < 0) {
        return -1;
    }
    open_how how{};
    how.flags = flags;
    how.resolve = RESOLVE_BENEATH | RESOLVE_NO_MAGICLINKS;
    constexpr int tries = 16;  // EAGAIN: something was renamed meanwhile.
    long file = -1;
    for (int n = 0; n < tries; ++n) {
        file = syscall(SYS_openat2, at, name.c_str(), &how, sizeof how);
        if (file >= 0 || errno != EAGAIN) {
            break;
        }
    }
    const int reason = errno;
    ::close(at);
    errno = reason;
    return static_cast<int>(file);
}

/// `file` as a name in `folder`; empty if the name leads elsewhere.
std::string name_in(const fs::path& folder, const fs::path& file) {
    const std::string begin =
        folder.string().ends_with('/') ? folder.string() : folder.string() + "/";
    if (file.string().starts_with(begin)) {
        return file.string().substr(begin.size());
    }
    const std::string name = file.lexically_normal().lexically_relative(folder).string();
    return name.starts_with("..") ? "" : name;
}

int open_in_header_folder(const fs::path& header, const fs::path& data) {
    const fs::path folder = fs::absolute(header).parent_path();
    const std::string name = name_in(folder, fs::absolute(data));
    if (name.empty()) {
        errno = EXDEV;
        return -1;
    }
    return open_beneath(folder, name);
}

/// Opens `data` if it lies, its links followed, in one of the folders; else -1.
int open_allowed(const fs::path& data, const AllowedFolders& allowed) {
    std::error_code failure;
    const fs::path real = fs::canonical(data, failure);
    for (const std::string& each : allowed) {
        const fs::path folder = failure ? fs::path() : fs::canonical(each, failure);
        const std::string name = failure ? "" : name_in(folder, real);
        if (const int file = name.empty() ? -1 : open_beneath(folder, name); file >= 0) {
            return file;
        }
    }
    return -1;
}

[[noreturn]] void refuse(const fs::path& header, const fs::path& data, int reason) {
    const std::string what = fmt::format("{}: its data file {}", header.string(), data.string());
    if (reason == EXDEV || reason == ELOOP) {
        throw ImportError(fmt::format(
            "{} lies outside of the header's folder. If the header is trusted, allow the folder of "
            "the data with --allow DIR, or move the data beside the header",
            what));
    }
    if (reason == ENOSYS || reason == EPERM) {
        throw ImportError(
            fmt::format("{} cannot be opened safely: this system does not offer openat2 (Linux "
                        "5.6). Put header "
                        "and data into one file, for example .nrrd or .mha",
                        what));
    }
    throw ImportError(fmt::format("{} cannot be read: {}", what, std::strerror(reason)));
}

}  // namespace

DataFile::DataFile(const fs::path& header, const fs::path& data, const AllowedFolders& allowed) {
    if (data == header) {
        file_ = ::open(data.c_str(), flags);
    } else {
        file_ = open_in_header_folder(header, data);
    }
    if (file_ < 0) {
        const int reason = errno;
        file_ = open_allowed(data, allowed);
        if (file_ < 0) {
            refuse(header, data, reason);
        }
    }
    struct stat facts {};
    if (fstat(file_, &facts) != 0 || !S_ISREG(facts.st_mode)) {
        ::close(file_);
        throw ImportError(fmt::format("{}: its data file {} cannot be read: it is no file",
                                      header.string(), data.string()));
    }
    facts_ = facts_now();
}

FileFacts DataFile::facts_now() const {
    struct stat facts {};
    fstat(file_, &facts);
    return facts_of(facts);
}

DataFile::~DataFile() {
    ::close(file_);
}

fs::path DataFile::path() const {
    return fmt::format("/proc/self/fd/{}", file_);
}

}  // namespace pxpl5::host::io
