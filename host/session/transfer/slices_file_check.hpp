// Checks the file that GPs read the values of a volume from.
#pragma once

#include <string>
#include <vector>

#include "ringbus/rules/slices_file.hpp"

namespace pxpl5::host {

/// Checks that `file` lies beside `source`, the file of the volume, or below, or in one of the
/// folders, links followed, and that its facts are those that the io process states.
/// Throws RequestError (bad_data) naming the file and both values.
void check_slices_file(const SlicesFile& file, const std::string& source,
                       const std::vector<std::string>& folders);

}  // namespace pxpl5::host
