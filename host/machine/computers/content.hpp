// A file as letters to the host.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "host/machine/computers/letter.hpp"

namespace pxpl5::host {

/// Says the parts of `file`, which is relative to `folder`, in order. Of a long log, only its end.
/// A file that cannot be read, or is not inside the folder, has one part with the error.
void send_content(const std::filesystem::path& folder, const std::string& file,
                  const std::function<void(join::ContentT)>& say);

}  // namespace pxpl5::host
