// Director: chooses when frames are drawn, and their size.
#include <algorithm>
#include <cmath>
#include <utility>

#include "host/base/error.hpp"
#include "host/commands/text/picture_text.hpp"
#include "host/serve/director/director.hpp"

namespace pxpl5::host::serve {

namespace {

constexpr int smallest_moving_px = 64;

Size scaled(const Size& size, double scale) {
    const auto side = [scale](int px) {
        return std::max(std::min(px, smallest_moving_px),
                        static_cast<int>(std::lround(px * scale)));
    };
    return {side(size.width), side(size.height)};
}

OnePicture one_picture(Picture picture) {
    return {picture.width, picture.height,
            std::make_shared<const std::vector<std::uint32_t>>(std::move(picture.rgba))};
}

/// Viewers who take depths compose the pictures of both eyes themselves.
Eyes eyes_of(ReadBack reads) {
    return reads == ReadBack::pixels_and_depths ? Eyes::apart : Eyes::composed;
}

}  // namespace

bool Director::has_picture() const {
    return session_->volumes.has_volume() || session_->volumes.archive() != nullptr;
}

void Director::show(Picture picture, int samples, bool rests, bool last) {
    Shown frame;
    if (picture.views == 1) {
        frame.digest = rests ? picture_digest(picture) : 0;
    } else if (rests) {  // The digest is that of the written picture.
        const Picture whole = composed_picture(picture, session_->scene.stereo.mode);
        frame.digest = picture_digest(whole);
        frame.as_one = [one = one_picture(whole)] { return one; };
    }
    frame.views = picture.views;
    frame.width = picture.width;
    frame.height = picture.height;
    frame.pixels = std::make_shared<const std::vector<std::uint32_t>>(std::move(picture.rgba));
    if (picture.views == 2 && !rests) {
        frame.as_one = [pixels = frame.pixels, width = picture.width, height = picture.height,
                        stereo = session_->scene.stereo.mode] {
            return one_picture(composed_picture({width, height, *pixels}, stereo));
        };
    }
    if (!picture.depths.empty()) {
        frame.depths =
            std::make_shared<const std::vector<std::uint32_t>>(std::move(picture.depths));
    }
    if (rests && samples == 1) {
        shown_.resting_depths = frame.depths;
    } else if (rests) {
        frame.depths = shown_.resting_depths;
    }
    frame.revision = revision_;
    frame.samples = samples;
    frame.rests = rests;
    frame.last = last;
    frame.moved_mm = session_->frames.last().moved_mm;
    frame.machine_ms = static_cast<float>(session_->frames.last().elapsed_ms);
    audience_.show(std::move(frame));
}

/// Moving pictures: the size is limited by the time of a frame, unless each row of the picture
/// belongs to a row of a monitor. With `detail auto`, the detail is
/// limited by the number of triangles.
Frames::Moving Director::moving() const {
    const Scene& scene = session_->scene;
    const double scale = scene.stereo.mode == StereoMode::rows
                             ? 1
                             : std::min(pace_.scale(), audience_.advice().scale);
    const Size size = scaled(scene.size, scale);
    if (!scene.detail.is_auto) {
        return {size, scene.detail.detail};
    }
    std::int64_t triangles = 0;
    for (const Surface& surface : scene.surfaces) {
        if (surface.visible && !is_compared(scene.surfaces, surface) &&
            session_->surfaces.has_report(surface.name)) {
            triangles += session_->surfaces.report_of(surface.name).triangles;
        }
    }
    return {size, moving_detail(triangles, parts_.moving_triangles)};
}

/// Depths only help viewers who show pictures from newer viewpoints. The holes of a screen door
/// show other surfaces from there.
ReadBack Director::read_back() const {
    const bool is_archive = session_->volumes.archive() != nullptr;
    const std::vector<Surface>& surfaces =
        is_archive ? session_->volumes.archive_surfaces() : session_->scene.surfaces;
    const auto is_seen_through = [&](const Surface& surface) {
        return surface.visible && surface.opacity != full_opacity &&
               !is_compared(surfaces, surface);
    };
    const bool has_depths =
        audience_.advice().wants_depths && std::ranges::none_of(surfaces, is_seen_through);
    return has_depths ? ReadBack::pixels_and_depths : ReadBack::pixels;
}

/// Requests the picture of a new isovalue together with the surface.
void Director::announce_frame(const Arguments& command) {
    const bool draws = command.name == "surface" && !command.words.empty() && has_picture() &&
                       audience_.wants_frame();
    const std::optional<Surface> known =
        draws ? session_->surfaces.find(command.words[0]) : std::nullopt;
    // A filter of components selects the triangles only after the extraction.
    const bool is_ahead = draws && (!known || known->components.kind == ComponentFilter::Kind::all);
    session_->frames.announce(is_ahead ? std::optional(moving()) : std::nullopt);
}

/// Draws a moving picture after a change. Returns false if nothing has changed.
bool Director::draw_moving() {
    if (!has_picture() || shown_.revision == revision_ || !audience_.wants_frame() ||
        (!inbox_.has_command() && since_ms(input_ns_) >= rest_ms)) {  // The resting picture is due.
        return false;
    }
    if (state_is_old_) {
        tell_state();  // The overlay of the page follows the state.
    }
    const Size wished = session_->scene.size;
    const DetailChoice chosen = session_->scene.detail;
    const std::int64_t start_ns = parts_.clock_ns();
    const std::uint32_t revision = revision_;
    guard("drawing", [&] {
        struct Restore {
            Scene& scene;
            Size size;
            DetailChoice detail;
            ~Restore() {
                scene.size = size;
                scene.detail = detail;
            }
        };
        const Restore restore{session_->scene, wished, chosen};
        const Frames::Moving now = moving();
        session_->scene.size = now.size;
        session_->scene.detail = {false, now.detail};
        const ReadBack reads = read_back();
        show(session_->frames.draw_samples(1, {}, reads, eyes_of(reads)).value(), 1, false, false);
    });
    pace_.drawn(since_ms(start_ns));
    shown_.time_ns = parts_.clock_ns();
    shown_.revision = revision;  // Also after a failure: the next change tries again.
    shown_.samples = 0;
    return true;
}

/// Draws the resting picture after a time without input, then with more samples. A command that
/// changes the picture cancels the refinement.
bool Director::draw_resting() {
    if (!has_picture() || since_ms(input_ns_) < rest_ms || !is_refinable()) {
        return false;
    }
    const std::uint32_t revision = revision_;
    const bool is_first = shown_.revision != revision || shown_.samples == 0 || lacks_depths();
    const int samples = *std::ranges::upper_bound(sample_counts, is_first ? 0 : shown_.samples);
    const ReadBack reads = read_back();
    bool is_drawn = true;
    guard("drawing", [&] {
        const auto go_on = [this] {
            take_events();
            answer_slices();
            return !inbox_.changes_picture();
        };
        auto picture = session_->frames.draw_samples(samples, go_on, reads, eyes_of(reads));
        is_drawn = picture.has_value();
        if (picture) {
            show(std::move(*picture), samples, true, samples == most_samples());
        }
    });
    if (is_drawn) {
        shown_.time_ns = parts_.clock_ns();
        shown_.revision = revision;
        shown_.samples = samples;
        shown_.read_depths = is_first ? reads == ReadBack::pixels_and_depths : shown_.read_depths;
    }
    return true;
}

/// Whether a viewer asks for the depths of the resting picture, which was drawn without them.
bool Director::lacks_depths() const {
    return shown_.revision == revision_ && shown_.samples > 0 && !shown_.read_depths &&
           read_back() == ReadBack::pixels_and_depths;
}

/// Samples per pixel of the last refinement.
int Director::most_samples() const {
    return session_->frames.max_samples();
}

/// Whether a better picture than the newest can be drawn.
bool Director::is_refinable() const {
    return shown_.revision != revision_ || shown_.samples < most_samples() || lacks_depths();
}

bool Director::wants_machine() const {
    return parts_.machine_text && std::ranges::any_of(viewers_, [](const auto& viewer) {
               return viewer.second.wants_machine;
           });
}

void Director::tell_machine() {
    guard("machine", [&] {
        const std::string text = "{\"machine\":" + parts_.machine_text(*session_) + "}";
        for (const auto& [id, viewer] : viewers_) {
            if (viewer.wants_machine) {
                audience_.send(id, text);
            }
        }
    });
    machine_text_ns_ = parts_.clock_ns();
}

}  // namespace pxpl5::host::serve
