// The sandbox of the io process: all that one request needs, and nothing else.
#pragma once

#include <cstdint>

#include "host/io/sandbox/file_rules.hpp"
#include "host/io/sandbox/system_calls.hpp"

namespace pxpl5::host::io {

/// The needs of one request.
struct Needs {
    Task task = Task::read;
    FileRules files;
    std::uint64_t file_bytes = 0;  ///< Largest file that may be written, beside the log.
};

/// Confines this process, with all of its threads, to `needs`: open descriptors, size of files,
/// no core file, no new privileges, files (restrict_files) and system calls
/// (restrict_system_calls). Limits that are set already become final. Cannot be undone.
///
/// Protections that the kernel lacks are left out. Has no effect in a build with a sanitizer.
/// Throws std::runtime_error if the kernel refuses a protection that it has.
void confine(const Needs& needs);

}  // namespace pxpl5::host::io
