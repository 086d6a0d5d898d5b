// The text of `info` on a file, for goldens: without the folder, which differs from machine to
// machine.
#pragma once

#include <fmt/format.h>

#include <string>

#include "host/commands/text/volume_text.hpp"
#include "host/io/import.hpp"

namespace pxpl5::test {

inline std::string without(std::string text, const std::string& folder) {
    for (std::size_t at = text.find(folder); at != std::string::npos; at = text.find(folder)) {
        text.erase(at, folder.size());
    }
    const std::string bare = folder.substr(0, folder.size() - 1);  // Without its last slash.
    for (std::size_t at = text.find(bare); at != std::string::npos; at = text.find(bare)) {
        text.replace(at, bare.size(), "FOLDER");
    }
    return text;
}

/// The file's name, and what `info` tells or why the file is refused.
inline std::string info(const host::io::ImportRequest& request, const std::string& folder) {
    std::string text;
    try {
        text =
            host::describe_volume(host::io::import_volume(request), host::VolumeDetail::brief).text;
    } catch (const host::io::ImportError& error) {
        text = std::string("refused: ") + error.what();
    }
    return fmt::format("== {}\n{}\n\n", without(request.path, folder), without(text, folder));
}

inline std::string info(const std::string& path, const std::string& folder) {
    host::io::ImportRequest request;
    request.path = path;
    return info(request, folder);
}

}  // namespace pxpl5::test
