// Answers the page's question for the contents of a folder: the file browser of the dialog Open.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "host/serve/director/file_access.hpp"

namespace pxpl5::host::serve {

inline constexpr std::size_t max_listed = 500;    ///< Entries of an answer.
inline constexpr std::size_t max_read = 100'000;  ///< Entries of a folder that are looked at.

/// Whether list_folder() answers this `ask` message.
bool asks_for_folder(std::string_view message);

/// Lists a folder that the browser may read, or the allowed folders if its path is empty. Hidden
/// entries, and links that lead out of the allowed folders, are left out.
///
/// message  {"ask":"folder","path":..,"find":..,"all":..}: entries whose names contain `find`,
///          without difference between large and small letters; all files instead of those whose
///          names look like volumes. Only path is required.
/// Returns  JSON as host/serve/README.md describes it. Folders come first, then files, each by
///          name; numbers in names count as numbers.
/// Throws   RequestError (usage) naming the path if it may not be read or is no folder.
std::string list_folder(const FileAccess& access, std::string_view message);

}  // namespace pxpl5::host::serve
