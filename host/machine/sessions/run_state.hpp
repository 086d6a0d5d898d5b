// Whether the program of a run folder has ended, on this computer or on another one.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace pxpl5::host {

/// Name of the file in a run folder that its program keeps locked.
inline constexpr const char* lock_name = "lock";

/// Returns the process id of the program that made the run folder `name`; nothing if `name` is not
/// the name of a run folder.
std::optional<pid_t> maker_of(const std::string& name);

/// The name of this computer or container, as manifests record it.
std::string computer_name();

/// The namespace of process ids, which mean something only in here: "pid:[4026531836]".
std::string pid_namespace();

/// A random number of the start of this computer.
std::string boot_id();

/// Returns when a process of this computer started, in clock ticks since the start of the computer;
/// nothing if no such process runs. Together with the process id it names one process, because
/// process ids are used again.
std::optional<std::int64_t> start_of(pid_t pid);

enum class RunState { ended, running, unknown };

/// Finds out whether the program of a run has ended, also one on another computer or in another
/// container that shares the folder.
class RunProbe {
  public:
    enum class Use {
        look,    ///< Several programs may look at the same time.
        remove,  ///< Keeps an ended run locked as long as the object exists.
    };
    RunProbe(const std::filesystem::path& run, pid_t maker, Use use);
    ~RunProbe();
    RunProbe(const RunProbe&) = delete;
    RunProbe& operator=(const RunProbe&) = delete;

    RunState state;

  private:
    int file_;
};

}  // namespace pxpl5::host
