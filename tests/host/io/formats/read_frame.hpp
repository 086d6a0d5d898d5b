// Reads one volume of a time series.
#pragma once

#include <cstdint>
#include <string>

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

}  // namespace pxpl5::test
