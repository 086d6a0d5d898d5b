// The frame that a running session shows: recorded by its nodes, opened, and asked about.
//
//   scene --draw--> frame --save_traces--> traces/*.mcap --RecordedRun--> why, scrub
//
// This header does not include the firmware.
#pragma once

#include <cstdint>
#include <memory>

#include "host/base/reply.hpp"
#include "host/inspect/step/scrub_view.hpp"
#include "host/session/session.hpp"

namespace pxpl5::host::inspect {

class LiveFrame {
  public:
    /// The frame of the session's scene as it is now. Drawn and saved if it is another than the one
    /// that was asked about last, which is kept in Session::asked; the files of an earlier
    /// frame are overwritten.
    /// Throws RequestError: usage if nothing is recorded; failed if the recorder holds less than
    /// the frame, saying what to do; else as Frames::draw() and
    /// Nodes::save_traces().
    static LiveFrame& of(Session& session);

    LiveFrame(const LiveFrame&) = delete;
    LiveFrame& operator=(const LiveFrame&) = delete;
    ~LiveFrame();

    /// Explains the color of pixel (x, y) of the session's picture. A pixel of a stereo picture
    /// belongs to one eye (eye_pixel()), and the picture of this eye is explained. Throws
    /// RequestError (usage) if the pixel is outside of the picture.
    Reply why(int x, int y);

    /// The region that holds pixel (x, y) behind `wish.at` of its instructions. Its stepper is kept
    /// for the next question about this region.
    /// Throws RequestError (usage) for a pixel outside, or a field that there is not.
    ScrubView scrub(int x, int y, const ScrubWish& wish);

  private:
    explicit LiveFrame(Session& session, std::uint64_t key);
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace pxpl5::host::inspect
