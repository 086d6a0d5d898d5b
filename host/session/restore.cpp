#include "host/session/restore.hpp"

#include <algorithm>

namespace pxpl5::host {

namespace {

bool wants(const Scene& wanted, const std::string& name) {
    return std::ranges::count(wanted.surfaces, name, &Surface::name) != 0;
}

/// Whether a comparison of the surface is to be shown.
bool wants_comparison(const Scene& wanted, const std::string& name) {
    return std::ranges::count(wanted.surfaces, name, &Surface::compared_with) != 0;
}

void remove_unwanted(Session& session, const Scene& wanted) {
    const std::vector<Surface> there = session.scene.surfaces;
    for (const Surface& surface : there) {
        if (!wants(wanted, surface.name)) {
            session.surfaces.remove(surface.name);
        }
    }
}

/// A surface, its components, and its comparison.
void restore_surface(Session& session, const Scene& wanted, const Surface& like) {
    const std::optional<Surface> there = session.surfaces.find(like.name);
    const bool is_new = !there || there->isovalue != like.isovalue || there->table != like.table;
    if (is_new) {
        session.surfaces.set(like.name, like.isovalue, like.table, like.colour);
    }
    if (session.surfaces.find(like.name)->components != like.components) {
        session.surfaces.set_components(like.name, like.components);
    }
    session.surfaces.set_style(like);
    if (!wants_comparison(wanted, like.name)) {
        session.surfaces.end_comparison(like.name);
    } else if (is_new || !is_compared(session.scene.surfaces, like)) {
        session.surfaces.compare(like.name);
    }
}

/// Drawing order decides which of two surfaces at one depth is seen.
void restore_order(std::vector<Surface>& surfaces, const Scene& wanted) {
    std::ranges::sort(surfaces, {}, [&](const Surface& surface) {
        return std::ranges::find(wanted.surfaces, surface.name, &Surface::name) -
               wanted.surfaces.begin();
    });
}

}  // namespace

void restore(Session& session, const Scene& wanted) {
    remove_unwanted(session, wanted);
    for (const Surface& surface : wanted.surfaces) {
        if (surface.compared_with.empty()) {
            restore_surface(session, wanted, surface);
        }
    }
    for (const Surface& surface : wanted.surfaces) {
        if (!surface.compared_with.empty()) {
            session.surfaces.set_style(surface);
        }
    }
    Scene& scene = session.scene;
    restore_order(scene.surfaces, wanted);
    scene.camera = wanted.camera;
    scene.lights = wanted.lights;
    scene.material = wanted.material;
    scene.background = wanted.background;
    scene.clips = wanted.clips;
    scene.tint_gaps = wanted.tint_gaps;
    scene.gap_colour = wanted.gap_colour;
}

void restore_all(Session& session, const Scene& wanted) {
    session.scene.size = wanted.size;
    session.scene.samples = wanted.samples;
    session.scene.overlay = wanted.overlay;
    restore(session, wanted);
}

}  // namespace pxpl5::host
