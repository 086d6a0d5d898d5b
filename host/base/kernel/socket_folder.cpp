#include "host/base/kernel/socket_folder.hpp"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <system_error>

#include "host/base/error.hpp"
#include "host/base/state_folder.hpp"

namespace pxpl5::host {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const std::string& what, const fs::path& path, const std::string& reason) {
    throw RequestError(ExitCode::failed, fmt::format("{} {}: {}", what, path.string(), reason));
}

/// True if a program listens at the socket, or may do so.
bool is_served(const fs::path& socket_path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string path = socket_path.string();
    if (path.size() >= sizeof address.sun_path) {
        return true;
    }
    std::ifstream sockets("/proc/net/unix");  // A look disturbs no host, a connection might.
    for (std::string line; std::getline(sockets, line);) {
        if (line.ends_with(" " + path)) {
            return true;
        }
    }
    std::memcpy(address.sun_path, path.data(), path.size());
    const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const bool is_refused =
        fd >= 0 && connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 &&
        errno == ECONNREFUSED;
    ::close(fd);
    return !is_refused;
}

/// Removes a folder without a lock, if it is empty and was empty for an hour: earlier versions made
/// no locks, and have left such folders.
void remove_empty(const fs::path& folder) {
    constexpr std::chrono::hours age{1};
    struct stat facts {};
    if (lstat(folder.c_str(), &facts) == 0 &&
        std::time(nullptr) - facts.st_mtime >= std::chrono::seconds(age).count()) {
        ::rmdir(folder.c_str());
    }
}

/// Returns whether the folder has no files.
bool has_only_sockets(const fs::path& folder) {
    std::error_code failure;
    const fs::directory_iterator entries(folder, failure);
    return !failure && std::all_of(begin(entries), end(entries), [](const auto& entry) {
        std::error_code unknown;
        return fs::is_socket(entry.symlink_status(unknown));
    });
}

/// Removes the folders of sockets whose program has ended: it has no lock any more, and no program
/// listens at the socket `host`.
void remove_stale_sockets(const fs::path& parent) {
    constexpr std::array<std::string_view, 1> begins{"pxpl5-"};
    remove_stale_folders(parent, begins, [](const fs::path& folder, bool has_lock) {
        struct stat socket_facts {};
        const fs::path host = folder / "host";
        if (!has_lock && !has_only_sockets(folder)) {
            return false;
        }
        if (lstat(host.c_str(), &socket_facts) == 0 && S_ISSOCK(socket_facts.st_mode)) {
            return !is_served(host);
        }
        if (!has_lock) {
            remove_empty(folder);
        }
        return has_lock;
    });
}

fs::path usual_socket_parent() {
    const char* runtime = std::getenv("XDG_RUNTIME_DIR");
    const bool usable = runtime != nullptr && *runtime == '/' && access(runtime, W_OK | X_OK) == 0;
    return usable ? fs::path(runtime) : temporary_parent();
}

}  // namespace

SocketFolder::SocketFolder() : SocketFolder(usual_socket_parent()) {
    remove_stale_temporary_folders();
}

SocketFolder::SocketFolder(const fs::path& parent) {
    remove_stale_sockets(parent);
    if (const int reason = folder_.make(parent, "pxpl5"); reason != 0) {
        refuse("cannot make a folder for sockets", parent / "pxpl5-XXXXXX", std::strerror(reason));
    }
}

void SocketFolder::mark_as_used() {
    const std::string path = folder_.path() / "host";
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    mark_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const bool fits = path.size() < sizeof address.sun_path;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    if (!fits || bind(mark_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
        listen(mark_, 1) != 0) {
        refuse("cannot listen in the folder for sockets", path,
               fits ? std::strerror(errno) : "its name is too long for a socket");
    }
}

SocketFolder::~SocketFolder() {
    if (mark_ >= 0) {
        ::close(mark_);
    }
}

std::string near_address(const std::filesystem::path& folder, const std::string& name) {
    return fmt::format("ipc://{}", (folder / name).string());
}

}  // namespace pxpl5::host
