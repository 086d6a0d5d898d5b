// A frame on its way back to the host: a message of each frame buffer that assembles a view of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/base/command_line.hpp"
#include "host/base/shared_words.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host {

/// A frame whose parts have all arrived. Views are stacked from top to bottom.
struct WholeFrame {
    std::uint32_t frame = 0;
    Size view;  ///< Pixels of one view.
    int views = 1;
    SharedWords pixels;                           ///< All views; empty unless read back.
    SharedWords depths;                           ///< Likewise; empty unless requested.
    std::vector<std::uint64_t> region_cycles;     ///< By region of all views.
    std::vector<std::uint16_t> region_renderers;  ///< Index of the Renderer, by region.
    std::uint64_t instructions = 0;
    double moved_mm = 0;
};

/// The parts of one frame. Frame buffers without a view of the frame send nothing.
class FrameParts {
  public:
    /// view           Size of each view that was requested.
    /// frame_buffers  Of the machine.
    FrameParts(Size view, std::size_t views, std::size_t frame_buffers);

    /// Keeps the FrameDone of frame buffer `index`. Throws MachineError that names the frame buffer
    /// if the message does not have the views that belong to it.
    void take(std::size_t index, const bus::Message& message);
    bool is_complete() const;
    /// The frame as one. The pixels of a single frame buffer stay in its message. The parts must be
    /// complete.
    WholeFrame whole() const;

  private:
    using Words = flatbuffers::Vector<std::uint32_t>;
    const bus::schema::FrameDone& part(std::size_t index) const;
    SharedWords joined(const Words* (bus::schema::FrameDone::*words)() const) const;

    Size view_;
    std::size_t views_;
    std::vector<std::optional<bus::Message>> parts_;  ///< By frame buffer; of those with a view.
};

}  // namespace pxpl5::host
