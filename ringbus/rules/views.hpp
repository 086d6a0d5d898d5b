// The views of a picture and the frame buffers that assemble them: all nodes share them out alike.
// Plain, for every stage.
#pragma once

#include <cstddef>

namespace pxpl5 {

/// Index of the frame buffer that assembles `view`. With two frame buffers, each eye has its own.
constexpr std::size_t frame_buffer_of(std::size_t view, std::size_t frame_buffers) {
    return view % frame_buffers;
}

/// Place of `view` among the views of its frame buffer.
constexpr std::size_t view_place(std::size_t view, std::size_t frame_buffers) {
    return view / frame_buffers;
}

/// How many of `views` views the frame buffer at `index` assembles. A frame buffer without views
/// takes no part in the frame.
constexpr std::size_t views_of(std::size_t views, std::size_t index, std::size_t frame_buffers) {
    return (views + frame_buffers - 1 - index) / frame_buffers;
}

}  // namespace pxpl5
