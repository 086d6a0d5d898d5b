// Frames: pictures of given eyes, pictures whose transparent surface is a layer, and pictures that
// are requested ahead.
#include <algorithm>
#include <utility>
#include <vector>

#include "host/session/frames.hpp"

namespace pxpl5::host {
namespace {

Scene scene_of_pair(Scene scene, const Frames::Moving& how) {
    scene.size = how.size;
    scene.detail = {false, how.detail};
    scene.stereo = {};
    return scene;
}

}  // namespace

Picture Frames::draw_pair(const Eyes& eyes, const Moving& how) {
    drop_ahead();
    const Scene scene = scene_of_pair(scene_, how);
    Stage seen = stage(scene);
    seen.cameras = {eyes.left, eyes.right};
    const std::vector<Surface> opaque = without_transparent(seen.surfaces);
    seen.surfaces = opaque;
    request(scene, seen, ReadBack::pixels_and_depths);
    return take_oldest();
}

std::optional<Frames::Layers> Frames::draw_pair_layers(const Eyes& eyes, const Moving& how) {
    const Scene scene = scene_of_pair(scene_, how);
    Stage seen = stage(scene);
    seen.cameras = {eyes.left, eyes.right};
    return draw_layers_of(scene, std::move(seen));
}

std::optional<Frames::Layers> Frames::draw_layers() {
    if (ahead_ && ahead_->layers && ahead_->key == key()) {
        wait_until_pending(0);
        if (const std::optional<Ahead> ahead = std::exchange(ahead_, std::nullopt)) {
            return take_layers(*ahead->layers);
        }  // Else it has failed.
    }
    Stage seen = stage(scene_);
    return seen.cameras.size() == 1 ? draw_layers_of(scene_, std::move(seen)) : std::nullopt;
}

std::optional<Frames::Layers> Frames::draw_layers_of(const Scene& scene, Stage part) {
    const std::optional<SurfaceLayers> layers = surface_layers(scene, part);
    if (!layers) {
        return std::nullopt;
    }
    drop_ahead();
    request_layers(scene, std::move(part), *layers);
    return take_layers(*layers);
}

void Frames::request_layers(const Scene& scene, Stage part, const SurfaceLayers& layers) {
    part.surfaces = layers.behind;
    request(scene, part, ReadBack::pixels_and_depths);
    const std::int64_t started_ns = pending_.back().started_ns;
    part.surfaces = {&layers.front, 1};
    part.planes = {};
    request(scene, part, ReadBack::pixels_and_depths);
    pending_.back().is_front = true;
    pending_.back().started_ns = started_ns;
}

Frames::Layers Frames::take_layers(const SurfaceLayers& layers) {
    wait_until_pending(0);
    Layers drawn{take_oldest(), take_oldest(), layers.opacity};
    std::vector<std::uint32_t> rgba = drawn.front.rgba.copy(), depths = drawn.front.depths.copy();
    put_in_front(drawn.behind.rgba, drawn.behind.depths, rgba, depths, layers.entries_before);
    drawn.front.rgba = std::move(rgba);
    drawn.front.depths = std::move(depths);
    return drawn;
}

void Frames::announce(const std::optional<Moving>& moving, bool as_layers) {
    drop_ahead();
    announced_ = moving;
    announces_layers_ = as_layers;
}

void Frames::request_announced() {
    if (const std::optional<Moving> moving = std::exchange(announced_, std::nullopt)) {
        Scene scene = scene_;
        scene.size = moving->size;
        scene.detail = {false, moving->detail};
        const Stage seen = stage(scene);
        ahead_ = {next_frame_, key_of(scene)};
        if (announces_layers_ && seen.cameras.size() == 1) {
            ahead_->layers = surface_layers(scene, seen);
        }
        if (ahead_->layers) {
            request_layers(scene, seen, *ahead_->layers);
        } else {
            request(scene, seen);
        }
    }
}

std::optional<Picture> Frames::take_ahead(int samples) {
    if (!ahead_) {
        return std::nullopt;
    }
    const bool has_layers = ahead_->layers.has_value();
    const bool is_wanted = samples == 1 && !has_layers && ahead_->key == key();
    wait_until_pending(0);
    if (!std::exchange(ahead_, std::nullopt)) {  // It has failed.
        return std::nullopt;
    }
    Picture picture = take_oldest();
    if (has_layers) {
        take_oldest();
    }
    return is_wanted ? std::optional(std::move(picture)) : std::nullopt;
}

}  // namespace pxpl5::host
