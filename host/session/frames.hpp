// Frames of the scene: requested, at most two in flight, and taken in order.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/base/shared_words.hpp"
#include "host/base/spread.hpp"
#include "host/scene/pick.hpp"
#include "host/session/nodes.hpp"
#include "host/session/transfer/frame_layers.hpp"
#include "host/session/transfer/frame_parts.hpp"
#include "host/session/transfer/frame_report.hpp"
#include "host/session/transfer/frame_request.hpp"
#include "host/session/volumes.hpp"

namespace pxpl5::host {

/// A finished picture, top row first.
struct Picture {
    int width = 0, height = 0;
    SharedWords rgba;  ///< views * width * height; red in the low byte.
    /// Depths as FrameDone has them, one per pixel and view; empty unless they were asked for.
    SharedWords depths = {};
    int views = 1;  ///< 2: width and height are one eye's; the left eye's pixels, then the right's.
};

/// The pictures of a stereo view.
enum class PairForm : std::uint8_t {
    composed,  ///< One picture, without depths.
    apart      ///< Two views.
};

/// A pair as one picture.
///
/// pair  The left eye's pixels, then the right eye's.
/// eye   Size of the picture of one eye.
Picture composed_picture(std::span<const std::uint32_t> pair, Size eye, StereoMode stereo);

/// A frame, and the counts that each GP and Renderer reports.
struct CountedFrame {
    std::uint32_t frame = 0;
    std::uint32_t width = 0, height = 0, views = 1;  ///< Pixels per view.
    Pass pass;
    std::vector<std::uint16_t> region_renderers;  ///< Index of the Renderer, by region.
    std::map<bus::NodeId, bus::schema::FrameCountsT> counts;
};

struct OrbitReport {
    int frames = 0;
    double elapsed_ms = 0;
    Spread latency_ms;  ///< Request to picture.
};

/// GPs prepare one frame while Renderers draw the other.
inline constexpr int max_frames_in_flight = 2;

class Frames {
  public:
    Frames(Conversation& conversation, Scene& scene, const Volumes& volumes, Nodes& nodes);

    /// A picture that is drawn while something moves.
    struct Moving {
        Size size;
        int detail = 0;
    };

    /// Draws the scene with its number of samples per pixel. If the Renderers have no room for the
    /// sums of the whole picture, draws parts of it, one after the other.
    Picture draw();
    /// Draws the scene with 1, 4 or 16 samples per pixel (sample_offset()), two passes at a time.
    /// Only a picture of one sample has depths; a frame that was requested ahead has none.
    /// Calls go_on, if any, before each pass. When go_on returns false, waits for the passes in
    /// flight and returns nothing. Throws RequestError (failed) as drawing does, and if the
    /// Renderers have no room for the sums: see max_samples().
    std::optional<Picture> draw_samples(int samples, const std::function<bool()>& go_on = {},
                                        ReadBack read_back = ReadBack::pixels,
                                        PairForm form = PairForm::composed);
    /// Draws the scene as two given eyes see it, with one sample and with depths, and without its
    /// transparent surfaces: the depths of a screen door show two surfaces at every place. The
    /// scene's camera, size, detail and stereo mode have no part in it. Returns two views. Drops a
    /// frame that was requested ahead. Throws RequestError (failed) as drawing does.
    ///
    /// how  Size of one eye's picture, and the detail.
    Picture draw_pair(const Eyes& eyes, const Moving& how);
    /// A picture with one transparent surface.
    struct Layers {
        Picture behind;   ///< Without the transparent surface.
        Picture front;    ///< With it, opaque. Only the pixels that show it have a depth.
        int opacity = 0;  ///< Sixteenths.
        int drawn = 0;    ///< How many of the pictures were drawn for it; the others are kept.
    };
    /// Draws the scene with one sample per pixel, as two pictures with depths. Both are in flight
    /// at the same time, or were requested ahead. A picture that would be the same as the newest
    /// one of its kind is not drawn again: while one surface changes, the other one's stays.
    /// Returns nothing in stereo, and unless exactly one visible surface has an opacity below 1.
    std::optional<Layers> draw_layers();
    /// The same as two given eyes see it: draw_pair() without the transparent surface, and with it.
    std::optional<Layers> draw_pair_layers(const Eyes& eyes, const Moving& how);
    /// Draws the exact scene, and drops the picture: one frame per sample, in order of samples.
    std::vector<CountedFrame> draw_counted();
    /// The most samples that the machine can draw a picture of the scene's size with.
    int max_samples() const;
    /// Draws `frames` frames around the volume, `in_flight` (1 or 2) at a time, and gives each to
    /// `take` in order, with its camera. The azimuth grows by `degrees` in all. Whole turns end one
    /// step before their begin, so that they can be repeated; the last frame of other turns is at
    /// their end. The scene's camera stays the same.
    using TakeFrame = std::function<void(int, const Picture&, const Camera&)>;
    OrbitReport orbit(int frames, const TakeFrame& take, int in_flight = max_frames_in_flight,
                      double degrees = 360);

    /// Announces that the next new surface is drawn once it is extracted, in this way and with one
    /// sample. Surfaces::set() then requests the frame together with the surface. Nothing: no such
    /// frame.
    ///
    /// as_layers  draw_layers() follows, if it can draw the scene: its frames are requested.
    void announce(const std::optional<Moving>& moving, bool as_layers = false);
    /// Requests the announced frame, if any. The next drawing takes the frame if it shows what is
    /// drawn, else drops the frame.
    void request_announced();
    /// True if a frame was requested ahead and not taken yet.
    bool has_frame_ahead() const { return ahead_.has_value(); }

    const FrameReport& last() const { return last_; }

    struct Picked {
        Pick pick;
        std::string surface;  ///< Empty for a point of a slice plane.
        int opacity = 0;      ///< Sixteenths.
        std::optional<ScenePlane> plane = {};
        bool is_opaque() const { return opacity == full_opacity; }
    };
    /// Returns the points of all visible surfaces and slice planes under the middle of pixel (x, y)
    /// from the top left, nearest first; of a stereo picture those that the eye of this pixel sees.
    /// Draws each surface once, alone and opaque, so that the holes of the screen door have no part
    /// in the answer. Throws RequestError for archives.
    std::vector<Picked> hits(int x, int y);
    /// Returns the nearest of `hits` on an opaque surface; without one, the nearest of all; nothing
    /// without hits. `surface`, if not empty, names the only surface that counts.
    static std::optional<Picked> chosen(std::span<const Picked> hits,
                                        const std::string& surface = "");
    std::optional<Picked> pick(int x, int y, const std::string& surface = "") {
        return chosen(hits(x, y), surface);
    }
    /// The sphere that the camera looks at.
    Subject subject() const { return stage(scene_).subject; }
    /// Why surfaces of the loaded volume cannot be simplified; empty if they can, or without one.
    std::string simplification_refusal() const;
    /// A digest of a frame's request and of the GPs' content. Two moments have the same key only if
    /// the frames drawn then are the same.
    std::uint64_t key() const { return key_of(scene_); }
    /// Waits for the frame ahead, if any, and drops it.
    void drop_ahead() { take_ahead(0); }
    /// Ignores the frames in flight, without waiting for them.
    void abandon();
    /// Forgets everything about the content of the GPs, because it is replaced.
    void forget_content();

  private:
    struct Pending {
        std::uint32_t frame = 0;
        std::int64_t started_ns = 0;  ///< Start of the picture's first pass.
        Pass pass;
        bool is_question = false;             ///< Asks for depths, and is no picture that is shown.
        StereoMode stereo = StereoMode::off;  ///< How two views are composed; off: not.
        FrameParts parts;                     ///< The messages that have arrived.
        bool is_front = false;                ///< Belongs to the picture of the frame before.
    };
    /// A picture, and how far its surfaces are from the exact ones, as FrameReport has it.
    struct Drawn {
        Picture picture;
        double moved_mm = 0;
    };
    /// A picture of layers, as the machine has drawn it, behind or in front.
    struct KeptLayer {
        std::uint64_t key = 0;  ///< Digest of the request and of what the GPs hold.
        Drawn drawn;
    };
    struct LayersRequest {
        SurfaceLayers layers;
        std::array<std::uint64_t, 2> keys{};
        std::array<bool, 2> is_drawn{};  ///< False: the kept picture is the same.
        std::int64_t started_ns = 0;
    };
    struct Ahead {
        std::uint64_t key = 0;
        std::optional<LayersRequest> layers = {};
    };

    Stage stage(const Scene& scene) const;
    std::uint64_t key_of(const Scene& scene) const;
    void request(const Scene& scene, const Stage& stage, ReadBack read_back = ReadBack::pixels,
                 Pass pass = {}, bool counts = false, PairForm form = PairForm::composed);
    std::size_t views() const { return scene_.stereo.mode == StereoMode::off ? 1 : 2; }
    /// How many regions all Renderers together have room to sum.
    std::size_t max_summed_regions(int samples) const;
    Picture draw_in_parts(int samples);
    std::optional<Layers> draw_layers_of(const Scene& scene, Stage part);
    LayersRequest request_layers(const Scene& scene, Stage part, SurfaceLayers layers);
    std::uint64_t key_of_layer(const Scene& scene, const Stage& part) const;
    /// Waits for the frames in flight.
    Layers take_layers(const LayersRequest& request);
    /// The point of one surface, or of one slice plane.
    std::optional<Pick> pick_alone(std::optional<Surface> surface, std::optional<ScenePlane> plane,
                                   const EyePixel& at);
    bool take_fault(std::uint32_t frame);
    void take_done(const bus::Message& message);
    void finish(Pending frame);
    void take_counts(const bus::Message& message);
    bool is_counted(const CountedFrame& frame) const;
    /// Takes the frame ahead if its key is the scene's; else waits for it and drops it. Drops
    /// layers.
    std::optional<Picture> take_ahead(int samples);
    /// Waits until at most `count` frames are in flight.
    void wait_until_pending(std::size_t count);
    Picture take_oldest() { return take_oldest_drawn().picture; }
    Drawn take_oldest_drawn();

    Conversation& conversation_;
    Scene& scene_;
    const Volumes& volumes_;
    Nodes& nodes_;
    std::uint32_t next_frame_ = 0;
    std::optional<Moving> announced_;
    bool announces_layers_ = false;
    std::optional<Ahead> ahead_;
    std::deque<Pending> pending_;
    std::deque<Drawn> finished_;
    std::array<std::optional<KeptLayer>, 2> kept_layers_;  ///< The newest ones.
    std::uint64_t frame_faults_ = 0;
    std::vector<CountedFrame> counted_;  ///< Being drawn.
    /// Costs of the regions of the newest frame with one view, and with two.
    std::array<std::vector<std::uint64_t>, 2> region_costs_;
    std::vector<std::uint64_t> picture_costs_;  ///< Costs that the newest picture is shared by.
    std::int64_t picture_started_ns_ = 0;
    FrameReport last_;
};

}  // namespace pxpl5::host
