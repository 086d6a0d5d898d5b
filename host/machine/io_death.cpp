// Launcher: the error for a request whose io process has died.
#include <fmt/format.h>

#include <csignal>

#include "host/base/error.hpp"
#include "host/machine/launcher.hpp"

namespace pxpl5::host {

namespace {

constexpr auto bad_data = static_cast<int>(ExitCode::bad_data);
constexpr const char* less_memory =
    "load a part with crop=, or fewer voxels with resample=, or end other programs";

std::string cause_of_kill(MemoryLack memory) {
    switch (memory) {
        case MemoryLack::found:
            return fmt::format(
                "The kernel ended a process at that time because this computer or its control "
                "group had run out of memory: {}",
                less_memory);
        case MemoryLack::perhaps:
            return fmt::format(
                "The kernel ended a process of this computer at that time because memory had run "
                "out, perhaps this one: {}. Otherwise a user or another program sent the signal: "
                "repeat the command",
                less_memory);
        case MemoryLack::none:
            return "The kernel did not end it for lack of memory, so a user or another program "
                   "sent the signal. Repeat the command";
        case MemoryLack::unknown:
            break;
    }
    return fmt::format(
        "A user or another program may have sent the signal: repeat the command. If this happens "
        "again, this computer may have run out of memory: {}",
        less_memory);
}

}  // namespace

MemoryLack memory_lack(const std::optional<MemoryKills>& before,
                       const std::optional<MemoryKills>& after) {
    if (!before || !after || before->is_own != after->is_own) {
        return MemoryLack::unknown;
    }
    if (before->count == after->count) {
        return MemoryLack::none;
    }
    return after->is_own ? MemoryLack::found : MemoryLack::perhaps;
}

IoFailure error_of(const IoDeath& io) {
    const std::string place = fmt::format(" (log: {})", io.log.string());
    const std::string fact =
        fmt::format("{}: {}{}{}", io.file, io.death.text(), io.doing.empty() ? "" : " ", io.doing);
    const std::string said = io.said.empty() ? "" : ": " + io.said;
    if (!io.has_request && io.death.signal != SIGKILL && io.death.signal != SIGSYS) {
        return {ExitCode::unavailable,
                fmt::format("{}{}. The file is hardly the reason: repeat the command{}", fact, said,
                            place)};
    }
    switch (io.death.signal) {
        case 0:
            break;
        case SIGKILL:  // An order of the host dismisses the process before.
            return {ExitCode::unavailable,
                    fmt::format("{}. {}{}", fact, cause_of_kill(io.memory), place)};
        case SIGSYS:
            return {ExitCode::failed,
                    fmt::format("{}: {} was ended by its sandbox: {}. A sound file does not lead "
                                "to this call. If the file is trusted, a library of this system "
                                "may need the call: load the file with --no-io-sandbox{}",
                                io.file, io.death.name,
                                io.said.empty() ? "system call unknown" : io.said, place)};
        case SIGXCPU:
            return {io.otherwise,
                    fmt::format("{}. It had used its {} s of processor time. The file may be "
                                "damaged; otherwise use a part of it with crop=, or fewer voxels "
                                "with resample={}",
                                fact, io.cpu_s, place)};
        default:
            return {io.otherwise,
                    fmt::format("{}{}{}{}", fact, said,
                                io.otherwise == ExitCode::bad_data
                                    ? ". The file may be damaged; if other programs read it, "
                                      "convert it with one of them"
                                    : "",
                                place)};
    }
    if (io.death.exit_code == bad_data && !io.said.empty()) {  // A library refused the file.
        return {ExitCode::bad_data,
                fmt::format("{}{}{}", io.said.starts_with(io.file) ? "" : io.file + ": ", io.said,
                            place)};
    }
    return {io.otherwise, fact + said + place};
}

}  // namespace pxpl5::host
