#include "host/inspect/why/live_frame.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "host/base/error.hpp"
#include "host/inspect/step/scrub.hpp"
#include "host/inspect/why/why.hpp"

namespace pxpl5::host::inspect {

namespace {

/// Draws the session's exact scene with one sample per pixel, and saves the traces.
std::pair<std::uint32_t, std::string> record_frame(Session& session) {
    struct Restore {
        Scene& scene;
        DetailChoice detail = scene.detail;
        ~Restore() { scene.detail = detail; }
    };
    const Restore restore{session.scene};
    session.scene.detail = {};  // A simplified triangle has no cell.
    session.frames.draw_samples(1);
    const std::uint32_t frame = session.frames.last().frame;
    return {frame, session.nodes.save_traces().folder};
}

/// Throws RequestError (failed) if regions of the frame cannot be executed again.
void check_is_whole(const RecordedRun& run, std::uint32_t number) {
    const std::vector<std::uint32_t> frames = run.frames();
    const bool is_there = std::ranges::find(frames, number) != frames.end();
    const std::string lacking =
        is_there ? fmt::format("{}", fmt::join(run.frame(number).missing, "; ")) : "no BeginFrame";
    if (!lacking.empty()) {
        throw RequestError(
            ExitCode::failed,
            fmt::format("the recorders do not have all of frame {} ({}): choose a smaller size, or "
                        "start the machine with --record full",
                        number, lacking));
    }
}

}  // namespace

struct LiveFrame::Parts {
    Parts(std::uint64_t its_key, std::uint32_t number, const std::string& folder,
          const Volume* volume, const Scene& scene)
        : key(its_key),
          run(RecordedRun::open(folder)),
          eye_size(scene.size),
          stereo(scene.stereo.mode) {
        check_is_whole(run, number);
        inquiry.emplace(run, number, volume);
    }

    /// The same pixel where the frame has it, whose views lie one below the other.
    EyePixel stacked(int x, int y) const {
        const Size size = composed_size(eye_size, stereo);
        if (x < 0 || x >= size.width || y < 0 || y >= size.height) {
            throw RequestError(
                ExitCode::usage,
                fmt::format("pixel ({}, {}) is outside of the picture, which has {} x {} pixels", x,
                            y, size.width, size.height));
        }
        EyePixel pixel = eye_pixel(x, y, eye_size, stereo);
        pixel.y += pixel.eye * eye_size.height;
        return pixel;
    }

    std::uint64_t key;
    RecordedRun run;
    Size eye_size;
    StereoMode stereo;
    std::optional<FrameInquiry> inquiry;
    std::optional<RegionScrub> scrub;
};

LiveFrame::LiveFrame(Session& session, std::uint64_t key) {
    const auto [frame, folder] = record_frame(session);
    const Volume* volume = session.volumes.has_volume() ? &session.volumes.volume() : nullptr;
    parts_ = std::make_unique<Parts>(key, frame, folder, volume, session.scene);
}

LiveFrame::~LiveFrame() = default;

LiveFrame& LiveFrame::of(Session& session) {
    const std::uint64_t key = session.frames.key();
    auto* kept = std::any_cast<std::shared_ptr<LiveFrame>>(&session.asked);
    if (kept == nullptr || (*kept)->parts_->key != key) {
        session.asked.reset();  // Before the next frame is opened, because each may be large.
        session.asked = std::shared_ptr<LiveFrame>(new LiveFrame(session, key));
        kept = std::any_cast<std::shared_ptr<LiveFrame>>(&session.asked);
    }
    return **kept;
}

Reply LiveFrame::why(int x, int y) {
    const EyePixel pixel = parts_->stacked(x, y);
    return answer_of(inspect::why(*parts_->inquiry, pixel.x, pixel.y)).reply();
}

ScrubView LiveFrame::scrub(int x, int y, const ScrubWish& wish) {
    const RecordedFrame& frame = parts_->inquiry->frame;
    const EyePixel pixel = parts_->stacked(x, y);
    const RegionPlace place = frame.region_at(pixel.x, pixel.y);
    if (!parts_->scrub || parts_->scrub->region() != place.number) {
        parts_->scrub.reset();
        parts_->scrub.emplace(frame.regions.at(place.number));
    }
    return parts_->scrub->view(wish, {pixel.x - place.x0_px, pixel.y - place.y0_px});
}

}  // namespace pxpl5::host::inspect
