// Volumes of a time series.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "host/io/values/import_request.hpp"

namespace pxpl5::host::io {

/// Throws ImportError if a time series does not have the volume that is asked for, or has more than
/// max_frames.
///
/// source  File or folder, for error texts.
/// holder  What has the volumes: "file", "series".
/// frame   Volume that is asked for, from 1; 0: none in particular.
/// frames  Volumes of the series; 1: there is no series.
/// why_one  Why there is no series, if that is not clear.
void check_frame(const std::string& source, std::string_view holder, std::uint32_t frame,
                 std::uint64_t frames, const std::string& why_one = "");

}  // namespace pxpl5::host::io
