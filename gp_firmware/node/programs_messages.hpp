// Programs messages: one GP's RegionPrograms of a frame. Triangles are set up inside the messages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gp_firmware/render/frame_drawing.hpp"
#include "ringbus/node.hpp"

namespace pxpl5::gp {

/// Returns a RegionPrograms without regions.
bus::Payload empty_programs_message(std::uint32_t frame, std::uint16_t gp_index,
                                    const DrawCounts& counts);

/// Sends a drawn frame to the Renderers in small pieces: one message per Renderer, in their order,
/// with its regions that have words. A message is allocated when all of its sizes are known; then
/// its words are written into it.
class ProgramsMessages {
  public:
    /// Throws bus::NodeFault if a Renderer's part is larger than a message may be.
    void begin(const FrameRequest& request, std::uint16_t gp_index, std::size_t renderer_count,
               const FrameDrawing& drawing);

    /// Writes regions until `triangle_count` triangles are written, and sends finished messages.
    ///
    /// drawing  The drawing that begin() received.
    /// Returns  true while more is left.
    bool send(const FrameDrawing& drawing, std::size_t triangle_count,
              std::span<const bus::NodeId> renderers, bus::Outbox& out);

    /// Returns the number of messages sent.
    std::size_t sent_count() const { return next_renderer_; }

    /// Drops an unfinished message.
    void drop() { payload_ = {}; }

  private:
    /// The place of a region's words in the message that is being written.
    struct Room {
        std::size_t region = 0;
        std::uint32_t* words = nullptr;
    };

    void make(const FrameDrawing& drawing, bus::Outbox& out);

    std::uint32_t frame_ = 0;
    std::uint16_t gp_index_ = 0;
    std::vector<std::vector<std::size_t>> regions_of_;  ///< Regions with words, per Renderer.
    bus::Payload empty_;
    std::size_t next_renderer_ = 0;
    bus::Payload payload_;     ///< The message of next_renderer_, if made_.
    std::vector<Room> rooms_;  ///< Regions of payload_; those from next_room_ on are not written.
    std::size_t next_room_ = 0;
    bool made_ = false;
};

}  // namespace pxpl5::gp
