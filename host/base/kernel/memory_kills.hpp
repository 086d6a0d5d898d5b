// Whether the kernel has ended processes because memory ran out.
#pragma once

#include <cstdint>
#include <istream>
#include <optional>

namespace pxpl5::host {

/// The number of processes that the kernel has killed for lack of memory since the start of this
/// computer, those of control groups included. Empty if the kernel does not count (before 4.13).
std::optional<std::uint64_t> memory_kills();

/// The same from the text of /proc/vmstat.
std::optional<std::uint64_t> memory_kills_in(std::istream& vmstat);

}  // namespace pxpl5::host
