#include "host/io/values/frames.hpp"

#include <fmt/format.h>

namespace pxpl5::host::io {

void check_frame(const std::string& source, std::string_view holder, std::uint32_t frame,
                 std::uint64_t frames, const std::string& why_one) {
    if (frame > frames) {
        throw ImportError(
            frames == 1
                ? fmt::format("{}: frame is {}, but the {} has one volume{}: load it "
                              "without frame=",
                              source, frame, holder, why_one.empty() ? "" : " (" + why_one + ")")
                : fmt::format("{}: frame is {}, but the {} has {} volumes: give frame=1 "
                              "to {}",
                              source, frame, holder, frames, frames));
    }
    if (frames > std::uint64_t{max_frames}) {
        throw ImportError(
            fmt::format("{}: has {} volumes, must be at most {}", source, frames, max_frames));
    }
}

}  // namespace pxpl5::host::io
