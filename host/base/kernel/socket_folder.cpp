#include "host/base/kernel/socket_folder.hpp"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

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

/// Removes folders of sockets at which no program listens any more. A young folder stays, because
/// its program may be about to listen.
void remove_stale_sockets(const fs::path& parent) {
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(parent, ignored)) {
        struct stat socket_facts {};
        const fs::path host = entry.path() / "host";
        if (is_stale_folder(entry.path(), "pxpl5-") && lstat(host.c_str(), &socket_facts) == 0 &&
            S_ISSOCK(socket_facts.st_mode) && !is_served(host)) {
            fs::remove_all(entry.path(), ignored);
        }
    }
}

fs::path usual_socket_parent() {
    const char* runtime = std::getenv("XDG_RUNTIME_DIR");
    const bool usable = runtime != nullptr && *runtime == '/' && access(runtime, W_OK | X_OK) == 0;
    return usable ? fs::path(runtime) : temporary_parent();
}

}  // namespace

bool is_stale_folder(const fs::path& folder, std::string_view begin) {
    constexpr std::chrono::seconds youth{10};
    constexpr std::size_t random_letters = 6;
    const std::string name = folder.filename().string();
    struct stat facts {};
    return name.starts_with(begin) && name.size() == begin.size() + random_letters &&
           lstat(folder.c_str(), &facts) == 0 && S_ISDIR(facts.st_mode) &&
           facts.st_uid == geteuid() && std::time(nullptr) - facts.st_mtime >= youth.count();
}

SocketFolder::SocketFolder() : SocketFolder(usual_socket_parent()) {}

SocketFolder::SocketFolder(const fs::path& parent) {
    remove_stale_sockets(parent);
    std::string pattern = parent / "pxpl5-XXXXXX";
    if (mkdtemp(pattern.data()) == nullptr) {
        refuse("cannot make a folder for sockets", pattern, std::strerror(errno));
    }
    path_ = pattern;
}

void SocketFolder::mark_as_used() {
    const std::string path = path_ / "host";
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
    std::error_code error;
    fs::remove_all(path_, error);
}

std::string near_address(const std::filesystem::path& folder, const std::string& name) {
    return fmt::format("ipc://{}", (folder / name).string());
}

}  // namespace pxpl5::host
