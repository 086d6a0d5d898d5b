// Director: chooses when frames are drawn, and their size.
#include <algorithm>
#include <functional>
#include <memory>
#include <utility>

#include "host/base/error.hpp"
#include "host/commands/text/picture_text.hpp"
#include "host/serve/director/director.hpp"
#include "host/serve/encoding/encode.hpp"
#include "host/serve/encoding/reduce.hpp"
#include "host/session/transfer/frame_layers.hpp"

namespace pxpl5::host::serve {

namespace {

constexpr int layers_of_a_picture = 2;

OnePicture one_picture(Picture picture) {
    return {picture.width, picture.height, std::move(picture.rgba)};
}

/// Viewers who take depths compose the pictures of both eyes themselves.
PairForm form_of(ReadBack reads) {
    return reads == ReadBack::pixels_and_depths ? PairForm::apart : PairForm::composed;
}

/// The words of a picture, and after them those of another one.
std::vector<std::uint32_t> stacked(const SharedWords& top, const SharedWords& below) {
    std::vector<std::uint32_t> words;
    words.reserve(top.size() + below.size());
    words.insert(words.end(), top.begin(), top.end());
    words.insert(words.end(), below.begin(), below.end());
    return words;
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
        Picture whole = composed_picture(picture.rgba, {picture.width, picture.height},
                                         session_->scene.stereo.mode);
        frame.digest = picture_digest(whole);
        frame.as_one = [one = one_picture(std::move(whole))] { return one; };
    }
    frame.views = picture.views;
    frame.width = picture.width;
    frame.height = picture.height;
    frame.pixels = picture.rgba;
    frame.depths = picture.depths;
    if (picture.views == 2 && !rests) {
        frame.as_one = [pixels = frame.pixels, width = picture.width, height = picture.height,
                        stereo = session_->scene.stereo.mode] {
            return one_picture(composed_picture(pixels, {width, height}, stereo));
        };
    }
    if (rests && samples == 1) {
        shown_.resting_revision = revision_;
        shown_.resting_views = frame.views;
        shown_.resting_depths = frame.depths;
    } else if (rests && shown_.resting_revision == revision_ &&
               shown_.resting_views == frame.views) {
        frame.depths = shown_.resting_depths;
    }
    frame.samples = samples;
    frame.rests = rests;
    frame.last = last;
    show_frame(std::move(frame));
}

void Director::show_frame(Shown frame) {
    frame.revision = revision_;
    frame.fixed_size = session_->scene.stereo.mode == StereoMode::rows;
    frame.scale = frame.rests ? 1 : shown_.scale;
    shown_.camera = session_->scene.camera;
    send_drawn(std::move(frame));
}

/// Draws a moving picture whose only transparent surface is a layer of its own. Returns false if no
/// surface is transparent, or several are, and in stereo.
bool Director::draw_layers() {
    std::optional<Frames::Layers> layers = session_->frames.draw_layers();
    if (!layers) {
        return false;
    }
    shown_.is_whole = layers->drawn == layers_of_a_picture;
    Shown frame;
    frame.width = layers->behind.width;
    frame.height = layers->behind.height;
    frame.layers = 2;
    frame.opacity = layers->opacity;
    frame.pixels = stacked(layers->behind.rgba, layers->front.rgba);
    frame.depths = stacked(layers->behind.depths, layers->front.depths);
    frame.as_one = [pixels = frame.pixels, width = frame.width, height = frame.height,
                    opacity = frame.opacity] {
        return one_picture({width, height, blended(pixels, 1, opacity)});
    };
    show_frame(std::move(frame));
    shown_.layers_revision = revision_;
    return true;
}

/// The same as one picture: the mean of the layers, without the holes of a screen door.
bool Director::draw_blended() {
    const std::optional<Frames::Layers> layers = session_->frames.draw_layers();
    if (layers) {
        const auto& [behind, front, opacity, drawn] = *layers;
        shown_.is_whole = drawn == layers_of_a_picture;
        show({behind.width, behind.height, blended(stacked(behind.rgba, front.rgba), 1, opacity)},
             1, false, false);
    }
    return layers.has_value();
}

/// Moving pictures: the size is limited by the time of a frame, unless each row of the picture
/// belongs to a row of a monitor.
double Director::moving_scale() const {
    return session_->scene.stereo.mode == StereoMode::rows
               ? 1
               : std::min(pace_.scale(), audience_.advice().scale);
}

/// With `detail auto`, the detail is limited by the number of triangles.
Frames::Moving Director::moving(double scale) const {
    return {moving_size(session_->scene.size, scale), moving_detail(1)};
}

/// views  Pictures that each triangle is drawn for.
int Director::moving_detail(int views) const {
    const Scene& scene = session_->scene;
    if (!scene.detail.is_auto) {
        return scene.detail.detail;
    }
    std::int64_t triangles = 0;
    for (const Surface& surface : scene.surfaces) {
        if (surface.visible && !is_compared(scene.surfaces, surface) &&
            session_->surfaces.has_report(surface.name)) {
            triangles += session_->surfaces.report_of(surface.name).triangles;
        }
    }
    return host::moving_detail(views * triangles, parts_.moving_triangles);
}

std::size_t Director::transparent_surfaces() const {
    const bool is_archive = session_->volumes.archive() != nullptr;
    return host::transparent_surfaces(is_archive ? session_->volumes.archive_surfaces()
                                                 : session_->scene.surfaces);
}

/// Depths only help viewers who show pictures from newer viewpoints. The holes of a screen door
/// show other surfaces from there.
ReadBack Director::read_back() const {
    return audience_.advice().wants_depths && transparent_surfaces() == 0
               ? ReadBack::pixels_and_depths
               : ReadBack::pixels;
}

/// Whether viewers who show pictures from newer viewpoints need layers of the newest state.
bool Director::lacks_layers() const {
    return shown_.layers_revision != revision_ && audience_.advice().wants_depths &&
           session_->scene.stereo.mode == StereoMode::off && transparent_surfaces() == 1;
}

/// Requests the picture of a new isovalue together with the surface.
void Director::announce_frame(const Arguments& command) {
    const bool draws = command.name == "surface" && !command.words.empty() && has_picture() &&
                       audience_.wants_frame() && has_onlookers();
    const std::optional<Surface> known =
        draws ? session_->surfaces.find(command.words[0]) : std::nullopt;
    // A filter of components selects the triangles only after the extraction.
    const bool is_ahead = draws && (!known || known->components.kind == ComponentFilter::Kind::all);
    session_->frames.announce(is_ahead ? std::optional(moving(moving_scale())) : std::nullopt,
                              true);
}

/// Draws with the size and the detail of moving pictures.
void Director::draw_as_moving(const std::function<void()>& draw) {
    struct Restore {
        Scene& scene;
        Size size;
        DetailChoice detail;
        ~Restore() {
            scene.size = size;
            scene.detail = detail;
        }
    };
    Scene& scene = session_->scene;
    const Restore restore{scene, scene.size, scene.detail};
    shown_.scale = moving_scale();
    const Frames::Moving now = moving(shown_.scale);
    scene.size = now.size;
    scene.detail = {false, now.detail};
    draw();
}

/// Draws a moving picture after a change. Returns false if nothing has changed.
bool Director::draw_moving() {
    if (!has_picture() || shown_.revision == revision_ || !audience_.wants_frame() ||
        !has_onlookers() ||
        (!inbox_.has_command() && since_ms(input_ns_) >= rest_ms)) {  // The resting picture is due.
        return false;
    }
    if (state_is_old_) {
        tell_state();  // The overlay of the page follows the state.
    }
    const std::int64_t start_ns = parts_.clock_ns();
    const std::uint32_t revision = revision_;
    shown_.is_whole = true;
    guard("drawing", [&] {
        draw_as_moving([&] {
            // Viewers need the layers themselves only while the camera moves.
            const bool is_turned = shown_.camera != session_->scene.camera;
            const bool is_drawn = is_turned && lacks_layers() ? draw_layers() : draw_blended();
            if (!is_drawn) {
                const ReadBack reads = read_back();
                show(session_->frames.draw_samples(1, {}, reads, form_of(reads)).value(), 1, false,
                     false);
            }
        });
    });
    pace_.drawn(since_ms(start_ns), shown_.is_whole);
    headset_.had_turn = false;
    shown_.time_ns = parts_.clock_ns();
    shown_.revision = revision;  // Also after a failure: the next change tries again.
    shown_.samples = 0;
    return true;
}

/// Draws the resting picture after a time without input, then layers of the state, unless the
/// moving picture had them, then the picture with more samples. A command that changes the picture
/// cancels the refinement, and so does a new pose of a headset.
bool Director::draw_resting() {
    if (!has_picture() || !is_refinable() || rest_due_ms() > 0) {
        return false;
    }
    const std::uint32_t revision = revision_;
    headset_.had_turn = false;
    if (shown_.revision == revision && shown_.samples > 0 && lacks_layers()) {
        guard("drawing", [&] { draw_as_moving([&] { draw_layers(); }); });
        shown_.layers_revision = revision;  // Also after a failure: the next change tries again.
        return true;
    }
    const bool is_first = shown_.revision != revision || shown_.samples == 0 || lacks_depths();
    const int samples = *std::ranges::upper_bound(sample_counts, is_first ? 0 : shown_.samples);
    // Refinements have the form of the first picture, whose depths they keep.
    const ReadBack reads = is_first             ? read_back()
                           : shown_.read_depths ? ReadBack::pixels_and_depths
                                                : ReadBack::pixels;
    bool is_drawn = true;
    guard("drawing", [&] {
        const auto go_on = [this, samples] {
            take_events();
            answer_slices();
            return !inbox_.changes_picture() && (samples == 1 || !is_pair_due());
        };
        auto picture = session_->frames.draw_samples(samples, go_on, reads, form_of(reads));
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

/// Whether a better picture than the newest can be drawn, and some viewer would see the picture.
bool Director::is_refinable() const {
    return has_onlookers() && (shown_.revision != revision_ || shown_.samples < most_samples() ||
                               lacks_depths() || lacks_layers());
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
