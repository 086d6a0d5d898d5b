#include "host/machine/run_folder.hpp"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <system_error>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/kernel/locked_folder.hpp"
#include "host/base/kernel/owned_descriptor.hpp"
#include "host/machine/sessions/run_state.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const std::string& what, const fs::path& path, const std::string& reason) {
    throw RequestError(ExitCode::failed, fmt::format("{} {}: {}", what, path.string(), reason));
}

/// Waits for the lock. True once this program has it.
bool take_lock(int file) {
    int result = 0;
    while ((result = flock(file, LOCK_EX)) != 0 && errno == EINTR) {
    }
    return result == 0;
}

/// Locks the run folder until this process ends, however it ends: the descriptor stays open, and no
/// child inherits it. The folders of one program share one lock, because each start of the machine
/// makes a folder. A file system without locks leaves the folder without a lock file.
/// Returns true if the folder has a lock of its own, for `locks`.
bool lock_run(const fs::path& folder, const std::vector<fs::path>& locks) {
    const fs::path lock = folder / lock_name;
    for (const fs::path& held : locks) {
        if (link(held.c_str(), lock.c_str()) == 0) {
            return false;
        }
    }
    const int file = ::open(lock.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
    if (file < 0) {
        refuse("cannot write", lock, std::strerror(errno));
    }
    if (take_lock(file)) {
        return true;
    }
    ::unlink(lock.c_str());
    ::close(file);
    return false;
}

/// Begin of a run folder's name until it is locked: programs that tidy now do not see it.
constexpr std::string_view new_begin = ".new-";

constexpr const char* config_name = "config.resolved.json";
constexpr const char* manifest_name = "manifest.json";

/// Removes the new folders of programs that were killed before they had named them. A folder with
/// any other file stays: no start has made it.
void remove_stale_new(const fs::path& base) {
    constexpr std::array own = {lock_name, config_name, manifest_name};
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(base, ignored)) {
        if (!is_stale_folder(entry.path(), new_begin, std::chrono::hours(1))) {
            continue;
        }
        std::set<std::string> names;
        for (const fs::directory_entry& each : fs::directory_iterator(entry.path(), ignored)) {
            names.insert(each.path().filename());
        }
        if (std::ranges::all_of(names, [&](const std::string& name) {
                return std::ranges::find(own, name) != own.end();
            })) {
            for (const std::string& name : names) {
                ::unlink((entry.path() / name).c_str());
            }
            ::rmdir(entry.path().c_str());
        }
    }
}

/// A folder that is removed unless it gets its name.
class NewFolder {
  public:
    explicit NewFolder(const fs::path& parent) {
        std::string pattern = parent / (std::string(new_begin) + "XXXXXX");
        if (mkdtemp(pattern.data()) == nullptr) {
            refuse("cannot make the run folder", pattern, std::strerror(errno));
        }
        path_ = pattern;
    }
    ~NewFolder() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    NewFolder(const NewFolder&) = delete;
    NewFolder& operator=(const NewFolder&) = delete;

    const fs::path& path() const { return path_; }

    /// Names it `name`, or `name`-2 and so on, because a program may start a second machine within
    /// the same second: a run folder is not empty, and renaming replaces only an empty folder.
    fs::path become(const fs::path& name) {
        fs::path folder = name;
        for (int n = 2; ::rename(path_.c_str(), folder.c_str()) != 0; ++n) {
            if (errno != EEXIST && errno != ENOTEMPTY) {
                refuse("cannot make the run folder", folder, std::strerror(errno));
            }
            folder = fmt::format("{}-{}", name.string(), n);
        }
        path_.clear();
        return folder;
    }

  private:
    fs::path path_;
};

/// Removes what ended runs need not keep, see make_run_folder().
void tidy_runs(const fs::path& base, int keep) {
    std::vector<fs::path> runs;
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(base, ignored)) {
        if (!entry.is_symlink(ignored) && entry.is_directory(ignored) &&
            maker_of(entry.path().filename().string())) {
            runs.push_back(entry.path());
        }
    }
    std::ranges::sort(runs, std::greater<>());  // Their names begin with the time.
    std::set<pid_t> running;  // A program whose machine was started again counts once.
    std::size_t ended = 0;
    for (const fs::path& run : runs) {
        const pid_t maker = *maker_of(run.filename().string());
        // Others may write to the base: only what lies in a folder of this user is removed, also
        // if another user puts a link in its place meanwhile.
        const OwnedDescriptor folder(
            open(run.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
        struct stat facts {};
        if (folder.fd < 0 || fstat(folder.fd, &facts) != 0 || facts.st_uid != geteuid()) {
            continue;
        }
        const fs::path held = fmt::format("/proc/self/fd/{}", folder.fd);
        const RunProbe probe(held, maker, RunProbe::Use::remove);
        if (probe.state == RunState::running) {
            running.insert(maker);
        }
        if (probe.state != RunState::ended) {
            continue;
        }
        ++ended;
        fs::remove_all(held / "uploads", ignored);
        if (keep > 0 && running.size() + ended > static_cast<std::size_t>(keep)) {
            fs::remove_all(run, ignored);
        }
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

/// The second word of the command line: "serve".
std::string subcommand() {
    std::ifstream file("/proc/self/cmdline");
    std::string word;
    std::getline(file, word, '\0');
    std::getline(file, word, '\0');
    return word;
}

std::string manifest(const Topology& topology, const std::string& started) {
    utsname system{};
    uname(&system);
    const char* const job = std::getenv("SLURM_JOB_ID");
    // Replaces bytes of the command line that are not UTF-8.
    return nlohmann::ordered_json{
        {"started", started},
        {"command_line", command_line()},
        {"subcommand", subcommand()},
        {"working_folder", fs::current_path().string()},
        {"version", PXPL5_VERSION},
        {"schema_hash", fmt::format("{:016x}", bus::schema_hash())},
        {"protocol_version", bus::protocol_version},
        {"topology", topology.name},
        {"pid", getpid()},
        {"process_start", start_of(getpid()).value_or(0)},
        {"job", job == nullptr ? "" : job},
        {"host",
         {{"system", fmt::format("{} {} {}", system.sysname, system.release, system.machine)},
          {"name", computer_name()},
          {"pid_namespace", pid_namespace()},
          {"boot_id", boot_id()},
          {"processor", proc_value("/proc/cpuinfo", "model name")},
          {"cores", sysconf(_SC_NPROCESSORS_ONLN)},
          {"memory", proc_value("/proc/meminfo", "MemTotal")}}}}
        .dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

void write_private_file(const fs::path& path, std::string_view text) {
    const int file =
        ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
    ssize_t written = 0;
    while (file >= 0 && !text.empty() && (written = ::write(file, text.data(), text.size())) > 0) {
        text.remove_prefix(static_cast<std::size_t>(written));
    }
    const int reason = errno;
    if (file < 0 || !text.empty()) {
        refuse("cannot write", path, std::strerror(reason));
    }
    ::close(file);
}

void make_private_folder(const fs::path& folder) {
    const char* const what = "cannot use the folder";
    struct stat facts {};
    if ((mkdir(folder.c_str(), S_IRWXU) != 0 && errno != EEXIST) ||
        lstat(folder.c_str(), &facts) != 0) {
        refuse(what, folder, std::strerror(errno));
    }
    if (!S_ISDIR(facts.st_mode)) {
        refuse(what, folder, "it is a link or a file. Remove it");
    }
    if (facts.st_uid != geteuid()) {
        refuse(what, folder,
               fmt::format("user {} owns it, and this program runs as user {}. Use another "
                           "--run-folder",
                           facts.st_uid, geteuid()));
    }
    constexpr mode_t permissions = 07777U, others = S_IRWXG | S_IRWXO;
    if ((facts.st_mode & others) != 0) {
        refuse(what, folder,
               fmt::format("it has mode {:04o}, so others may use it; it must have 0700. Run: "
                           "chmod 700 {}",
                           facts.st_mode & permissions, folder.string()));
    }
}

fs::path make_run_folder(const fs::path& base, const Topology& topology, int keep) {
    const std::tm utc = fmt::gmtime(std::time(nullptr));
    const std::string name = fmt::format("{:%Y%m%dT%H%M%SZ}-{}", utc, getpid());
    std::error_code error;
    const fs::path parent = fs::absolute(base);
    fs::create_directories(parent.parent_path(), error);
    if (!error && mkdir(parent.c_str(), 0700) != 0 && errno != EEXIST) {
        error.assign(errno, std::generic_category());
    }
    if (error) {
        refuse("cannot make the run folder", parent / name, error.message());
    }
    static std::vector<fs::path> locks;
    NewFolder made(parent);
    const bool has_own_lock = lock_run(made.path(), locks);
    write_private_file(made.path() / config_name, resolved_json(topology));
    write_private_file(made.path() / manifest_name,
                       manifest(topology, fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", utc)) + "\n");
    fs::path folder = made.become(parent / name);
    if (has_own_lock) {
        locks.push_back(folder / lock_name);
    }
    remove_stale_new(parent);
    tidy_runs(parent, keep);
    return folder;
}

std::string last_words(const std::filesystem::path& log) {
    std::ifstream file(log);
    std::string line, last;
    std::getline(file, line);  // The first line names the program.
    while (std::getline(file, line)) {
        last = line.empty() ? last : line;
    }
    return last;
}

}  // namespace pxpl5::host
