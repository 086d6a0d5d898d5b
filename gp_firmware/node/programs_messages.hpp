// Node programs: one GP's RegionPrograms of a frame, set up where they will be sent from.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gp_firmware/render/frame_drawing.hpp"
#include "ringbus/node.hpp"

namespace pxpl5::gp {

/// A RegionPrograms that says that there is nothing.
bus::Payload empty_programs_message(std::uint32_t frame, std::uint16_t gp_index,
                                    const DrawCounts& counts);

/// The way of a frame that is drawn to the Renderers, in small pieces: one message for each, in
/// their order, with those of its regions that have words. A message is made when all of its sizes
/// are known, and its words are written into it.
class ProgramsMessages {
  public:
    /// Throws bus::NodeFault if a Renderer's part is larger than a message may be.
    void begin(const FrameRequest& request, std::uint16_t gp_index, std::size_t renderer_count,
               const FrameDrawing& drawing);

    /// Writes regions until `triangle_count` triangles have been written, and sends what is done.
    ///
    /// drawing  As begin() knows it.
    /// Returns  true while there is more.
    bool send(const FrameDrawing& drawing, std::size_t triangle_count,
              std::span<const bus::NodeId> renderers, bus::Outbox& out);

    /// Renderers that have got theirs.
    std::size_t sent_count() const { return next_renderer_; }

    /// Forgets a message that is half done.
    void drop() { payload_ = {}; }

  private:
    /// Of a region within the message that is being written.
    struct Room {
        std::size_t region = 0;
        std::uint32_t* words = nullptr;
    };

    void make(const FrameDrawing& drawing, bus::Outbox& out);

    std::uint32_t frame_ = 0;
    std::uint16_t gp_index_ = 0;
    std::vector<std::vector<std::size_t>> regions_of_;  ///< Of each Renderer: those with words.
    bus::Payload empty_;
    std::size_t next_renderer_ = 0;
    bus::Payload payload_;     ///< Of next_renderer_, if begun.
    std::vector<Room> rooms_;  ///< In payload_; from next_room_ on still to be written.
    std::size_t next_room_ = 0;
    bool made_ = false;
};

}  // namespace pxpl5::gp
