#include "host/io/values/file_facts.hpp"

#include <fmt/format.h>

#include "host/io/values/import_request.hpp"

namespace pxpl5::host::io {

FileFacts facts_of(const struct stat& file) {
    constexpr std::int64_t ns_per_s = 1'000'000'000;
    return {static_cast<std::uint64_t>(file.st_size), file.st_ino,
            file.st_mtim.tv_sec * ns_per_s + file.st_mtim.tv_nsec};
}

FileFacts facts_of(const std::filesystem::path& file) {
    struct stat found {};
    if (stat(file.c_str(), &found) != 0 || !S_ISREG(found.st_mode)) {
        throw ImportError(fmt::format("{}: is no regular file", file.string()));
    }
    return facts_of(found);
}

}  // namespace pxpl5::host::io
