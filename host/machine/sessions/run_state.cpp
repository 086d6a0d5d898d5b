#include "host/machine/sessions/run_state.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>
#include <system_error>

#include "host/machine/sessions/json_values.hpp"

namespace pxpl5::host {

namespace {

namespace fs = std::filesystem;

/// Without a lock, the manifest says where the number of the maker is that of a process.
RunState state_by_manifest(const fs::path& run, pid_t maker) {
    const nlohmann::json read = read_json(run / "manifest.json");
    const nlohmann::json host = read.is_object() ? read.value("host", nlohmann::json()) : read;
    const auto is_here = [&](const char* key, const std::string& here, bool if_absent) {
        return host.is_object() && host.contains(key) ? host[key] == here : if_absent;
    };
    if (!is_here("name", computer_name(), false) ||
        !is_here("pid_namespace", pid_namespace(), true)) {
        return RunState::unknown;
    }
    return kill(maker, 0) == 0 || errno == EPERM ? RunState::running : RunState::ended;
}

}  // namespace

std::optional<pid_t> maker_of(const std::string& name) {
    constexpr std::string_view example = "20261123T093000Z-";
    const auto is_like = [](char c, char model) {
        return model >= '0' && model <= '9' ? c >= '0' && c <= '9' : c == model;
    };
    if (name.size() <= example.size() ||
        !std::equal(example.begin(), example.end(), name.begin(),
                    [&](char model, char c) { return is_like(c, model); })) {
        return std::nullopt;
    }
    pid_t pid = 0;
    const char* end = name.data() + name.size();
    const auto [stop, error] = std::from_chars(name.data() + example.size(), end, pid);
    if (error != std::errc{} || pid <= 0) {
        return std::nullopt;
    }
    // A second run of the same second is called NAME-2.
    const std::string_view rest(stop, end);
    const bool is_number = rest.size() > 1 && rest.front() == '-' &&
                           rest.find_first_not_of("0123456789", 1) == std::string_view::npos;
    return rest.empty() || is_number ? std::optional(pid) : std::nullopt;
}

std::string computer_name() {
    utsname system{};
    uname(&system);
    return system.nodename;
}

std::string pid_namespace() {
    std::error_code ignored;
    return fs::read_symlink("/proc/self/ns/pid", ignored).string();
}

std::string boot_id() {
    std::ifstream file("/proc/sys/kernel/random/boot_id");
    std::string line;
    std::getline(file, line);
    return line;
}

std::optional<std::int64_t> start_of(pid_t pid) {
    std::ifstream file(fmt::format("/proc/{}/stat", pid));
    std::string line;
    std::getline(file, line);
    const std::size_t name_end = line.rfind(')');  // A name may have blanks and parentheses.
    if (name_end == std::string::npos) {
        return std::nullopt;
    }
    constexpr int fields_before = 19;  // State to itrealvalue. Source: proc(5), field 22.
    std::istringstream fields(line.substr(name_end + 1));
    std::string skipped;
    for (int i = 0; i < fields_before; ++i) {
        fields >> skipped;
    }
    std::int64_t ticks = 0;
    return fields >> ticks ? std::optional(ticks) : std::nullopt;
}

RunProbe::RunProbe(const fs::path& run, pid_t maker, Use use)
    : file_(::open((run / lock_name).c_str(),
                   O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC)) {
    if (file_ < 0) {
        state = errno == ENOENT ? state_by_manifest(run, maker) : RunState::unknown;
    } else if (flock(file_, (use == Use::look ? LOCK_SH : LOCK_EX) | LOCK_NB) == 0) {
        state = RunState::ended;
    } else {
        state = errno == EWOULDBLOCK ? RunState::running : RunState::unknown;
    }
}

RunProbe::~RunProbe() {
    if (file_ >= 0) {
        ::close(file_);
    }
}

}  // namespace pxpl5::host
