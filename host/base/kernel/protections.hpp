// The protections of this kernel with which a process can confine itself.
#pragma once

#include <string>
#include <vector>

namespace pxpl5::host {

/// Returns the version of the kernel's Landlock interface; 0 if Landlock is absent or off.
int landlock_version();

/// Returns true if the kernel filters system calls (seccomp).
bool has_system_call_filters();

/// Returns one text per protection of the io process that this kernel lacks: its name, what the
/// process may do without it, and the remedy.
std::vector<std::string> missing_protections(int landlock, bool has_filters);

}  // namespace pxpl5::host
