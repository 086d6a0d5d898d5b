#include "host/session/transfer/slices_file_check.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "host/base/error.hpp"

namespace pxpl5::host {

namespace {

namespace fs = std::filesystem;

/// Whether `file`, which has no links, lies in `folder` or below.
bool lies_in(const fs::path& file, const fs::path& folder) {
    std::error_code failure;
    const fs::path real = fs::canonical(folder, failure);
    const fs::path name = failure ? fs::path() : file.lexically_relative(real);
    return !name.empty() && *name.begin() != "..";
}

[[noreturn]] void refuse(const std::string& source, const std::string& reason) {
    throw RequestError(ExitCode::bad_data, fmt::format("{}: {}", source, reason));
}

}  // namespace

void check_slices_file(const SlicesFile& file, const std::string& source,
                       const std::vector<std::string>& folders) {
    std::error_code failure;
    const fs::path real = fs::canonical(file.path, failure);
    if (failure) {
        refuse(source, fmt::format("its data file {}: {}", file.path, failure.message()));
    }
    const bool is_source = fs::equivalent(real, source, failure);
    const bool is_beside = lies_in(real, fs::absolute(source).parent_path());
    if (!is_source && !is_beside &&
        std::ranges::none_of(folders, [&](const auto& each) { return lies_in(real, each); })) {
        refuse(source, fmt::format("its data file {} lies outside of the header's folder. If the "
                                   "header is trusted, allow the folder of the data with --allow "
                                   "DIR",
                                   file.path));
    }
    constexpr std::int64_t ns_per_s = 1'000'000'000;
    struct stat now {};
    if (stat(real.c_str(), &now) != 0 || !S_ISREG(now.st_mode)) {
        refuse(source, fmt::format("its data file {} is no regular file", file.path));
    }
    const FileFacts facts{static_cast<std::uint64_t>(now.st_size), now.st_ino,
                          now.st_mtim.tv_sec * ns_per_s + now.st_mtim.tv_nsec};
    if (facts != file.facts) {
        refuse(source,
               fmt::format("its data file {} has {} bytes, inode {}, and changed at {} ns; the io "
                           "process read {} bytes, inode {}, changed at {} ns. Load it again when "
                           "it is complete",
                           file.path, facts.size_bytes, facts.inode, facts.modified_ns,
                           file.facts.size_bytes, file.facts.inode, file.facts.modified_ns));
    }
}

}  // namespace pxpl5::host
