#include "host/base/state_folder.hpp"

#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <system_error>

#include "host/base/error.hpp"

namespace pxpl5::host {

namespace {

namespace fs = std::filesystem;

/// A relative path in the environment counts as none, as the specification says.
fs::path absolute_of(const char* variable) {
    const char* text = std::getenv(variable);
    const fs::path path = text == nullptr ? "" : text;
    return path.is_absolute() ? path : fs::path();
}

[[noreturn]] void refuse_temporary(const std::string& folder, const std::string& reason) {
    throw RequestError(ExitCode::failed,
                       fmt::format("the folder for temporary files {} cannot be used: {}. Set "
                                   "TMPDIR to a folder that can be written",
                                   folder, reason));
}

}  // namespace

fs::path default_run_base() {
    if (const fs::path state = absolute_of("XDG_STATE_HOME"); !state.empty()) {
        return state / "pxpl5";
    }
    const fs::path home = absolute_of("HOME");
    return home.empty() ? fs::path("run") : home / ".local" / "state" / "pxpl5";
}

fs::path temporary_parent() {
    std::error_code error;
    const fs::path parent = fs::temp_directory_path(error);
    if (error) {
        const char* named = std::getenv("TMPDIR");
        refuse_temporary(named == nullptr ? "/tmp" : named, error.message());
    }
    return fs::absolute(parent);  // A relative TMPDIR is one of the current folder.
}

void remove_stale_temporary_folders() {
    static const std::string info = fmt::format("{}-", info_folder);
    static const std::string classes = fmt::format("{}-", class_folder);
    std::error_code failure;
    const fs::path parent = fs::temp_directory_path(failure);
    if (!failure) {
        remove_stale_folders(parent, std::array<std::string_view, 2>{info, classes},
                             [](const fs::path&, bool has_lock) { return has_lock; });
    }
}

TemporaryFolder::TemporaryFolder(const std::string& name) {
    const fs::path parent = temporary_parent();
    remove_stale_temporary_folders();
    if (const int reason = folder_.make(parent, name); reason != 0) {
        refuse_temporary(parent.string(), std::strerror(reason));
    }
}

}  // namespace pxpl5::host
