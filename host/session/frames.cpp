#include "host/session/frames.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <span>
#include <utility>

#include "host/base/digest.hpp"
#include "host/base/error.hpp"
#include "host/base/stopwatch.hpp"
#include "host/session/transfer/detail.hpp"
#include "host/session/transfer/picture_parts.hpp"
#include "host/session/transfer/scene_transfer.hpp"
#include "isa/contract/sample_sums.hpp"
#include "ringbus/rules/regions.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

/// The picture of a frame. Unless stereo is off, two views become one picture without depths.
Picture picture_of(const WholeFrame& done, StereoMode stereo) {
    if (done.views == 1 || stereo == StereoMode::off) {
        return {done.view.width, done.view.height, done.pixels, done.depths, done.views};
    }
    return composed_picture(done.pixels, done.view, stereo);
}

}  // namespace

Picture composed_picture(std::span<const std::uint32_t> pair, Size eye, StereoMode stereo) {
    const Size size = composed_size(eye, stereo);
    return {size.width, size.height, composed(pair, eye, stereo)};
}

Frames::Frames(Conversation& conversation, Scene& scene, const Volumes& volumes, Nodes& nodes)
    : conversation_(conversation), scene_(scene), volumes_(volumes), nodes_(nodes) {
    conversation_.handle(bus::Body::FrameDone,
                         [this](const bus::Message& message) { take_done(message); });
    conversation_.handle(bus::Body::FrameCounts,
                         [this](const bus::Message& message) { take_counts(message); });
    conversation_.handle_frame_faults([this](std::uint32_t frame) { return take_fault(frame); });
}

std::string Frames::simplification_refusal() const {
    return volumes_.has_volume()
               ? host::simplification_refusal(volumes_.volume(),
                                              static_cast<int>(conversation_.gps().size()))
               : std::string();
}

Stage Frames::stage(const Scene& scene) const {
    if (volumes_.archive() != nullptr) {
        return {volumes_.archive_surfaces(),       scene_subject(), glm::dmat4(1.0), false, 0,
                cameras_of(scene, scene_subject())};
    }
    const Volume& held = volumes_.volume();
    const glm::dvec3 last(held.nx - 1, held.ny - 1, last_place(held));
    const bool is_simplified = scene.detail.detail > 0 && simplification_refusal().empty();
    const Subject subject = subject_of(last, held.voxel_to_patient);
    const int detail = is_simplified ? scene.detail.detail : 0;
    return {scene_.surfaces,
            subject,
            held.voxel_to_patient,
            !held.gap_slabs.empty(),
            detail,
            cameras_of(scene, subject),
            scene.planes};
}

void Frames::request(const Scene& scene, const Stage& stage, ReadBack read_back, Pass pass,
                     bool counts, PairForm form) {
    if (pass.sample == 0) {
        picture_costs_ = region_costs_.at(stage.cameras.size() - 1);
        picture_started_ns_ = now_ns();
    }
    const bus::Payload message =
        frame_request(scene, stage, next_frame_, picture_costs_, read_back, pass, counts);
    const StereoMode stereo = form == PairForm::apart ? StereoMode::off : scene.stereo.mode;
    pending_.push_back({next_frame_++, picture_started_ns_, pass, false, stereo,
                        FrameParts(scene.size, stage.cameras.size(),
                                   conversation_.machine().frame_buffer_ids().size())});
    conversation_.machine().send(conversation_.gps().front(), message);
}

/// Returns whether drawing fails. Each GP reports a failed frame, and only the first fault counts.
bool Frames::take_fault(std::uint32_t frame) {
    ++frame_faults_;
    const bool is_pending = std::ranges::count(pending_, frame, &Pending::frame) != 0;
    if (is_pending && ahead_) {  // All frames in flight are then ahead.
        abandon();  // The next drawing requests the frame again, and reports its fault.
        return false;
    }
    return is_pending;
}

/// A frame buffer may be a frame ahead of another one. Frames finish in order all the same.
void Frames::take_done(const bus::Message& message) {
    const auto pending =
        std::ranges::find(pending_, message.as<schema::FrameDone>()->frame(), &Pending::frame);
    if (pending == pending_.end()) {
        return;  // The frame was abandoned.
    }
    const std::vector<bus::NodeId>& senders = conversation_.machine().frame_buffer_ids();
    const auto sender = std::ranges::find(senders, message.source());
    pending->parts.take(static_cast<std::size_t>(sender - senders.begin()), message);
    while (!pending_.empty() && pending_.front().parts.is_complete()) {
        Pending frame = std::move(pending_.front());
        pending_.pop_front();
        finish(std::move(frame));
    }
}

void Frames::finish(Pending frame) {
    const WholeFrame done = frame.parts.whole();
    if (!done.pixels.empty()) {
        finished_.push_back({picture_of(done, frame.stereo), done.moved_mm});
    }
    if (frame.is_question) {
        return;
    }
    nodes_.count_frame();
    if (frame.pass.sample == 0 && !frame.is_front) {
        last_ = {};
    }
    add_pass(done, last_);
    if (const auto counted = std::ranges::find(counted_, done.frame, &CountedFrame::frame);
        counted != counted_.end()) {
        counted->views = static_cast<std::uint32_t>(done.views);
        counted->region_renderers = done.region_renderers;
    }
    last_.elapsed_ms = ms_since(frame.started_ns);
    region_costs_.at(static_cast<std::size_t>(done.views) - 1) =
        frame.is_front ? last_.region_cycles : done.region_cycles;
}

void Frames::abandon() {
    pending_.clear();
    finished_.clear();
    ahead_.reset();
}

void Frames::forget_content() {
    abandon();
    announced_.reset();
    kept_layers_ = {};
    region_costs_ = {};
}

void Frames::wait_until_pending(std::size_t count) {
    const Conversation::Cancelable cancelable(conversation_);
    try {
        conversation_.wait("frame",
                           [&] { return pending_.size() <= count || conversation_.has_fault(); });
    } catch (...) {
        abandon();
        throw;
    }
}

Frames::Drawn Frames::take_oldest_drawn() {
    if (finished_.empty()) {
        wait_until_pending(pending_.size() - 1);
    }
    Drawn drawn = std::move(finished_.front());
    finished_.pop_front();
    return drawn;
}

Picture Frames::draw() {
    const int samples = scene_.samples;
    return samples <= max_samples() ? *draw_samples(samples) : draw_in_parts(samples);
}

std::optional<Picture> Frames::draw_samples(int samples, const std::function<bool()>& go_on,
                                            ReadBack read_back, PairForm form) {
    const ReadBack read = samples == 1 ? read_back : ReadBack::pixels;
    if (std::optional<Picture> picture = take_ahead(samples)) {
        return picture;
    }
    for (Pass pass{0, samples}; pass.sample < samples; ++pass.sample) {
        wait_until_pending(max_frames_in_flight - 1);
        if (go_on && !go_on()) {
            wait_until_pending(0);  // The machine holds two frames, not more.
            return std::nullopt;
        }
        request(scene_, stage(scene_), read, pass, false, form);
    }
    wait_until_pending(0);
    return take_oldest();
}

std::size_t Frames::max_summed_regions(int samples) const {
    return conversation_.renderer_count() *
           isa::max_summed_regions(static_cast<std::uint32_t>(samples));
}

int Frames::max_samples() const {
    const auto px = [](int length) { return static_cast<std::uint32_t>(length); };
    const std::size_t regions =
        region_count(px(scene_.size.width), px(scene_.size.height), views());
    int most = 1;
    for (const int samples : sample_counts) {
        if (samples > 1 && regions <= max_summed_regions(samples)) {
            most = samples;
        }
    }
    return most;
}

Picture Frames::draw_in_parts(int samples) {
    struct Restore {
        Scene& scene;
        const Size size = scene.size;
        ~Restore() {
            scene.size = size;
            scene.part.reset();
        }
    };
    const Restore whole{scene_};
    const auto count = [](int length) { return static_cast<std::size_t>(length); };
    std::vector<std::uint32_t> pixels(views() * count(whole.size.width) * count(whole.size.height));
    double elapsed_ms = 0;
    for (const SizedPart& part : parts_of(whole.size, max_summed_regions(samples) / views())) {
        scene_.part = part.place;
        scene_.size = part.size;
        const std::optional<Picture> drawn =
            draw_samples(samples, {}, ReadBack::pixels, PairForm::apart);
        put_part(part, {drawn->rgba.data(), drawn->rgba.size()}, pixels);
        elapsed_ms += last_.elapsed_ms;
    }
    last_.elapsed_ms = elapsed_ms;
    return views() == 1 ? Picture{whole.size.width, whole.size.height, std::move(pixels)}
                        : composed_picture(pixels, whole.size, scene_.stereo.mode);
}

std::uint64_t Frames::key_of(const Scene& scene) const {
    Digest digest;
    const bus::Payload message = frame_request(scene, stage(scene), 0, {});
    digest.add(std::as_bytes(message.bytes()));
    const std::array<std::uint64_t, 2> content = {volumes_.id(), conversation_.broadcasts()};
    digest.add(std::as_bytes(std::span(content)));
    return digest.value();
}

std::optional<Pick> Frames::pick_alone(std::optional<Surface> surface,
                                       std::optional<ScenePlane> plane, const EyePixel& at) {
    Stage alone = stage(scene_);
    alone.detail = 0;  // The point is exact.
    alone.surfaces = {};
    if (surface) {
        surface->opacity = full_opacity;
        alone.surfaces = {&*surface, 1};
    }
    alone.planes = {};
    if (plane) {
        alone.planes = {&*plane, 1};
    }
    alone.has_gaps = false;
    alone.cameras = {alone.cameras.at(static_cast<std::size_t>(at.eye))};
    request(scene_, alone, ReadBack::pixels_and_depths);
    pending_.back().is_question = true;
    const Picture picture = take_oldest();
    return host::pick({alone.cameras.front(), picture.width, picture.height, picture.depths}, at.x,
                      at.y, volumes_.volume());
}

std::vector<Frames::Picked> Frames::hits(int x, int y) {
    volumes_.volume();  // Throws for archives.
    drop_ahead();
    const EyePixel at = eye_pixel(x, y, scene_.size, scene_.stereo.mode);
    std::vector<Picked> found;
    for (const Surface& surface : scene_.surfaces) {
        if (surface.visible && !is_compared(scene_.surfaces, surface)) {
            if (const std::optional<Pick> hit = pick_alone(surface, {}, at)) {
                found.push_back({*hit, surface.name, surface.opacity});
            }
        }
    }
    for (const ScenePlane& plane : scene_.planes) {
        if (const std::optional<Pick> hit = pick_alone({}, plane, at)) {
            found.push_back({*hit, "", full_opacity, plane});
        }
    }
    std::ranges::stable_sort(found, {}, [](const Picked& hit) { return hit.pick.depth; });
    return found;
}

std::optional<Frames::Picked> Frames::chosen(std::span<const Picked> hits,
                                             const std::string& surface) {
    const auto counts = [&](const Picked& hit) {
        return surface.empty() || hit.surface == surface;
    };
    const auto opaque = std::ranges::find_if(
        hits, [&](const Picked& hit) { return counts(hit) && hit.is_opaque(); });
    const auto first = opaque != hits.end() ? opaque : std::ranges::find_if(hits, counts);
    return first != hits.end() ? std::optional(*first) : std::nullopt;
}

OrbitReport Frames::orbit(int frames, const TakeFrame& take, int in_flight, double degrees) {
    assert(in_flight >= 1 && in_flight <= max_frames_in_flight);
    drop_ahead();
    // Restores the camera and leaves no frame of the orbit over, also if `take` throws.
    struct Restore {
        Frames& frames;
        const Camera before = frames.scene_.camera;
        ~Restore() {
            frames.scene_.camera = before;
            frames.abandon();
        }
    };
    const Restore restore{*this};
    const int steps = std::fmod(degrees, 360) == 0 ? frames : std::max(frames - 1, 1);
    const auto camera_of = [&](int index) {
        Camera camera = restore.before;
        camera.angles.azimuth_deg += degrees * index / steps;
        return camera;
    };
    std::vector<double> latencies_ms;
    const std::int64_t start_ns = now_ns();
    for (int requested = 0, taken = 0; taken < frames; ++taken) {
        // A picture of several samples already has two passes in flight.
        const bool is_single = scene_.samples == 1;
        for (; is_single && requested < frames && requested - taken < in_flight; ++requested) {
            scene_.camera = camera_of(requested);
            request(scene_, stage(scene_));
        }
        if (!is_single) {
            scene_.camera = camera_of(taken);
        }
        const Picture picture = is_single ? take_oldest() : draw();
        latencies_ms.push_back(last_.elapsed_ms);
        take(taken, picture, camera_of(taken));
    }
    return {frames, ms_since(start_ns), spread_of(std::move(latencies_ms))};
}

void Frames::take_counts(const bus::Message& message) {
    const auto& counts = *message.as<schema::FrameCounts>();
    const auto counted = std::ranges::find(counted_, counts.frame(), &CountedFrame::frame);
    if (counted != counted_.end()) {
        counts.UnPackTo(&counted->counts[message.source()]);
    }
}

/// Returns whether all counts of the frame have arrived.
bool Frames::is_counted(const CountedFrame& frame) const {
    const auto has_reported = [&](bus::NodeId node) { return frame.counts.contains(node); };
    return !frame.region_renderers.empty() &&
           std::ranges::all_of(conversation_.gps(), has_reported) &&
           std::ranges::all_of(conversation_.machine().renderer_ids(), has_reported);
}

std::vector<CountedFrame> Frames::draw_counted() {
    struct Forget {
        std::vector<CountedFrame>& counted;
        ~Forget() { counted.clear(); }
    };
    const Forget forget{counted_};
    drop_ahead();
    for (Pass pass{0, scene_.samples}; pass.sample < scene_.samples; ++pass.sample) {
        wait_until_pending(max_frames_in_flight - 1);
        CountedFrame& frame = counted_.emplace_back();
        frame.frame = next_frame_;
        frame.width = static_cast<std::uint32_t>(scene_.size.width);
        frame.height = static_cast<std::uint32_t>(scene_.size.height);
        frame.pass = pass;
        Stage exact = stage(scene_);
        exact.detail = 0;  // The model of the machine of 1993 knows slabs, not blocks.
        request(scene_, exact, ReadBack::pixels, pass, true);
    }
    wait_until_pending(0);
    take_oldest();
    conversation_.wait("counts of the frame", [this] {
        return conversation_.has_fault() ||
               std::ranges::all_of(counted_,
                                   [this](const CountedFrame& f) { return is_counted(f); });
    });
    return std::move(counted_);
}

}  // namespace pxpl5::host
