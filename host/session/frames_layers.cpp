// Frames: pictures of given eyes, and pictures whose transparent surface is a layer.
#include <algorithm>
#include <utility>
#include <vector>

#include "host/session/frames.hpp"
#include "host/session/transfer/frame_layers.hpp"

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
    Stage seen = stage(scene_);
    return seen.cameras.size() == 1 ? draw_layers_of(scene_, std::move(seen)) : std::nullopt;
}

std::optional<Frames::Layers> Frames::draw_layers_of(const Scene& scene, Stage part) {
    const std::optional<SurfaceLayers> layers = surface_layers(scene, part);
    if (!layers) {
        return std::nullopt;
    }
    drop_ahead();
    part.surfaces = layers->behind;
    request(scene, part, ReadBack::pixels_and_depths);
    const std::int64_t started_ns = pending_.back().started_ns;
    part.surfaces = {&layers->front, 1};
    request(scene, part, ReadBack::pixels_and_depths);
    pending_.back().is_front = true;
    pending_.back().started_ns = started_ns;
    wait_until_pending(0);
    Layers drawn{take_oldest(), take_oldest(), layers->opacity};
    std::vector<std::uint32_t> rgba = drawn.front.rgba.copy(), depths = drawn.front.depths.copy();
    put_in_front(drawn.behind.rgba, drawn.behind.depths, rgba, depths, layers->entries_before);
    drawn.front.rgba = std::move(rgba);
    drawn.front.depths = std::move(depths);
    return drawn;
}

}  // namespace pxpl5::host
