#include "host/machine/run_folder.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "host/base/error.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const std::string& what, const fs::path& path, const std::string& reason) {
    throw RequestError(ExitCode::failed, fmt::format("{} {}: {}", what, path.string(), reason));
}

void write_file(const fs::path& path, const std::string& text) {
    std::ofstream file(path);
    file << text;
    file.close();
    if (!file) {
        refuse("cannot write", path, std::strerror(errno));
    }
}

/// The value of "key : value" in a table of /proc; empty if the key is missing.
std::string proc_value(const char* path, const std::string& key) {
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        const std::size_t colon = line.find(':');
        if (line.starts_with(key) && colon != std::string::npos) {
            const std::size_t from = line.find_first_not_of(" \t", colon + 1);
            return from == std::string::npos ? "" : line.substr(from);
        }
    }
    return {};
}

std::string command_line() {
    std::ifstream file("/proc/self/cmdline");
    std::string text((std::istreambuf_iterator<char>(file)), {});
    for (char& c : text) {
        c = c == '\0' ? ' ' : c;
    }
    return text.empty() ? text : text.substr(0, text.size() - 1);
}

std::string manifest(const Topology& topology, const std::string& started) {
    utsname system{};
    uname(&system);
    // Replaces bytes of the command line that are not UTF-8.
    return nlohmann::ordered_json{
        {"started", started},
        {"command_line", command_line()},
        {"working_folder", fs::current_path().string()},
        {"version", PXPL5_VERSION},
        {"schema_hash", fmt::format("{:016x}", bus::schema_hash())},
        {"protocol_version", bus::protocol_version},
        {"topology", topology.name},
        {"pid", getpid()},
        {"host",
         {{"system", fmt::format("{} {} {}", system.sysname, system.release, system.machine)},
          {"name", system.nodename},
          {"processor", proc_value("/proc/cpuinfo", "model name")},
          {"cores", sysconf(_SC_NPROCESSORS_ONLN)},
          {"memory", proc_value("/proc/meminfo", "MemTotal")}}}}
        .dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

fs::path make_run_folder(const fs::path& base, const Topology& topology) {
    const std::tm utc = fmt::gmtime(std::time(nullptr));
    const std::string name = fmt::format("{:%Y%m%dT%H%M%SZ}-{}", utc, getpid());
    std::error_code error;
    fs::create_directories(base, error);
    fs::path folder = fs::absolute(base) / name;
    // A program that starts a second machine within the same second numbers the folders.
    for (int n = 2; !error && !fs::create_directory(folder, error) && !error; ++n) {
        folder = fs::absolute(base) / fmt::format("{}-{}", name, n);
    }
    if (error) {
        refuse("cannot make the run folder", folder, error.message());
    }
    write_file(folder / "config.resolved.json", resolved_json(topology));
    write_file(folder / "manifest.json",
               manifest(topology, fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", utc)) + "\n");
    return folder;
}

SocketFolder::SocketFolder() {
    const char* runtime = std::getenv("XDG_RUNTIME_DIR");
    std::error_code error;
    const bool usable = runtime != nullptr && access(runtime, W_OK | X_OK) == 0;
    std::string pattern =
        (usable ? fs::path(runtime) : fs::temp_directory_path(error)) / "pxpl5-XXXXXX";
    if (error || mkdtemp(pattern.data()) == nullptr) {
        refuse("cannot make a folder for sockets", pattern, std::strerror(errno));
    }
    path_ = pattern;
}

SocketFolder::~SocketFolder() {
    std::error_code error;
    fs::remove_all(path_, error);
}

}  // namespace pxpl5::host
