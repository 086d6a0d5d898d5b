// Reads volumes of a time series.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/io/import.hpp"

namespace pxpl5::test {

/// frame  From 1; 0: none is asked for.
inline host::Volume read_frame(const std::string& path, std::uint32_t frame,
                               ReadBy by = ReadBy::host) {
    host::io::ImportRequest request;
    request.path = path;
    request.frame = frame;
    request.read = by;
    return host::io::import_volume(request);
}

/// Volumes `first` to `last`, by one Importer.
inline std::vector<host::Volume> read_in_turn(const std::string& path, std::uint32_t first,
                                              std::uint32_t last) {
    host::io::ImportRequest request;
    request.path = path;
    host::io::Importer importer(request);
    std::vector<host::Volume> volumes;
    for (std::uint32_t frame = first; frame <= last; ++frame) {
        volumes.push_back(importer.read(frame, frame < last));
    }
    return volumes;
}

}  // namespace pxpl5::test
