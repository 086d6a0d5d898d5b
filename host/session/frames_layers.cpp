// Frames: pictures of given eyes, pictures whose transparent surface is a layer, and pictures that
// are requested ahead.
#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "host/base/digest.hpp"
#include "host/base/stopwatch.hpp"
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
    return take_layers(request_layers(scene, std::move(part), *layers));
}

/// Frames name the revisions of their surfaces, so that new surfaces are part of the request. A
/// fault may come after its frame, which lacks triangles: what was drawn before it is not used.
std::uint64_t Frames::key_of_layer(const Scene& scene, const Stage& part) const {
    Digest digest;
    const bus::Payload message = frame_request(scene, part, 0, {}, ReadBack::pixels_and_depths);
    digest.add(std::as_bytes(message.bytes()));
    const std::array<std::uint64_t, 3> content = {volumes_.id(), conversation_.other_changes(),
                                                  frame_faults_};
    digest.add(std::as_bytes(std::span(content)));
    return digest.value();
}

Frames::LayersRequest Frames::request_layers(const Scene& scene, Stage part, SurfaceLayers layers) {
    LayersRequest made{std::move(layers)};
    made.started_ns = now_ns();
    for (const std::size_t layer : {0, 1}) {
        const bool is_front = layer == 1;
        if (is_front) {
            part.surfaces = {&made.layers.front, 1};
            part.planes = {};
        } else {
            part.surfaces = made.layers.behind;
        }
        made.keys[layer] = key_of_layer(scene, part);
        const std::optional<KeptLayer>& kept = kept_layers_[layer];
        made.is_drawn[layer] = !kept || kept->key != made.keys[layer];
        if (made.is_drawn[layer]) {
            request(scene, part, ReadBack::pixels_and_depths);
            pending_.back().is_front = is_front && made.is_drawn[0];
            pending_.back().started_ns = made.started_ns;
        }
    }
    return made;
}

Frames::Layers Frames::take_layers(const LayersRequest& request) {
    wait_until_pending(0);
    std::array<Drawn, 2> drawn;
    for (const std::size_t layer : {0, 1}) {
        std::optional<KeptLayer>& kept = kept_layers_[layer];
        if (request.is_drawn[layer]) {
            kept = {request.keys[layer], take_oldest_drawn()};
        }
        drawn[layer] = kept->drawn;
    }
    auto& [behind, front] = drawn;
    last_.moved_mm = std::max(behind.moved_mm, front.moved_mm);
    const auto count = static_cast<int>(std::ranges::count(request.is_drawn, true));
    if (count == 0) {
        last_.instructions = last_.renderer_cycles = 0;
        std::ranges::fill(last_.region_cycles, 0);
        last_.elapsed_ms = ms_since(request.started_ns);
    }
    std::vector<std::uint32_t> rgba = front.picture.rgba.copy();
    std::vector<std::uint32_t> depths = front.picture.depths.copy();
    put_in_front(behind.picture.rgba, behind.picture.depths, rgba, depths,
                 request.layers.entries_before);
    front.picture.rgba = std::move(rgba);
    front.picture.depths = std::move(depths);
    return {std::move(behind.picture), std::move(front.picture), request.layers.opacity, count};
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
        ahead_ = {key_of(scene)};
        std::optional<SurfaceLayers> layers;
        if (announces_layers_ && seen.cameras.size() == 1) {
            layers = surface_layers(scene, seen);
        }
        if (layers) {
            ahead_->layers = request_layers(scene, seen, std::move(*layers));
        } else {
            request(scene, seen);
        }
    }
}

std::optional<Picture> Frames::take_ahead(int samples) {
    if (!ahead_) {
        return std::nullopt;
    }
    const bool is_wanted = samples == 1 && !ahead_->layers && ahead_->key == key();
    wait_until_pending(0);
    if (!is_wanted) {
        finished_.clear();  // All of them were requested ahead.
    }
    const bool has_failed = !std::exchange(ahead_, std::nullopt);
    return is_wanted && !has_failed ? std::optional(take_oldest()) : std::nullopt;
}

}  // namespace pxpl5::host
