// System calls that a confined process may still make.
#pragma once

namespace pxpl5::host::io {

enum class Task {
    read,   ///< Decodes a file of a stranger.
    write,  ///< Writes a picture or a mesh, which takes names and removes them.
};

/// Lets all threads of this process make only the system calls that `task` and the ring need, by
/// seccomp. Cannot be undone. New connections, processes and executable memory are refused.
///
/// A call that libraries may try fails with EPERM. A call that only a program in foreign hands
/// makes ends the process with SIGSYS, after "system call NAME (NUMBER)" on standard error.
///
/// Returns  false if the kernel has no filters of system calls.
/// Throws   std::runtime_error if the kernel refuses the filter.
bool restrict_system_calls(Task task);

}  // namespace pxpl5::host::io
