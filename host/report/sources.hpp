// Which surfaces a report is about, by the names that people give them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host/timing/paper_rows.hpp"

namespace pxpl5::host::report {

/// A row of the paper's results, and where it is drawn from.
struct Source {
    timing::PaperRow row;
    std::string name;    ///< "pelvis/skin"; of a file "ct-knee/skin".
    std::string volume;  ///< The argument of Volumes::load().
};

/// The phantoms' rows and, if a folder is given, those of its volumes; only those of `names` if
/// there are any, in the order of the table.
///
/// Throws RequestError: a name that no row has (usage; the nearest or the known ones), no such
/// folder or a file missing in it (bad_data).
std::vector<Source> sources_of(const std::string& data_folder, std::span<const std::string> names);

}  // namespace pxpl5::host::report
