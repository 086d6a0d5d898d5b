// Where the programs of the machine are.
#pragma once

#include <filesystem>

namespace pxpl5::host {

/// The folder of the running program, in which the others are, too. Throws RequestError
/// (unavailable) if /proc does not say.
std::filesystem::path program_folder();

}  // namespace pxpl5::host
