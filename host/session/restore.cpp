#include "host/session/restore.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "host/session/transfer/slices_file_check.hpp"

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
        session.surfaces.set(like.name, like.isovalue, like.table, like.color);
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
    if (session.volumes.has_volume() && session.volumes.volume().frame != wanted.frame) {
        session.series.show(wanted.frame);
    }
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
    scene.planes = wanted.planes;
    scene.planes_window = wanted.planes_window;
    scene.tint_gaps = wanted.tint_gaps;
    scene.gap_color = wanted.gap_color;
}

void show_frame(Session& session, int frame) {
    check_frame(session.volumes.volume(), frame);
    const Scene before = session.scene;
    Scene wanted = before;
    wanted.frame = frame;
    try {
        restore(session, wanted);
    } catch (const RequestError&) {
        if (session.scene.frame != before.frame || !same_parameters(session.scene, before)) {
            go_back(session, before);
        }
        throw;
    }
}

void go_back(Session& session, const Scene& wanted) {
    if (!session.volumes.has_volume()) {
        return;  // A GP could not hold the volume: nothing is loaded.
    }
    const Conversation::Uncancelable whole(session.conversation);
    try {
        restore(session, wanted);
    } catch (const RequestError& error) {
        throw RequestError(ExitCode::failed,
                           fmt::format("volume {} and its surfaces cannot be shown again: {}",
                                       wanted.frame, error.what()));
    }
}

/// Shows the wanted volume of a time series, or leaves the one that the host has given the GPs.
void show_wanted_frame(Session& session, Scene& wanted) {
    try {
        session.series.show(wanted.frame);
    } catch (const RequestError&) {  // Its file is gone, for example.
        if (!session.volumes.has_volume()) {
            throw;
        }
        wanted.frame = session.volumes.volume().frame;
    }
}

void Session::begin_again(const Scene& wanted) {
    const Conversation::Uncancelable whole(conversation);
    conversation.begin_again();
    nodes.begin_again();
    volumes.give_again();
    Scene possible = wanted;
    if (!volumes.has_volume()) {
        possible.surfaces.clear();  // A load has dropped the volume and did not finish.
    } else {
        show_wanted_frame(*this, possible);
    }
    restore_all(*this, possible);
}

void Session::begin_again_or_drop(const Scene& wanted) {
    try {
        begin_again(wanted);
    } catch (const RequestError& error) {
        scene.surfaces.clear();
        history.note_losses(wanted, scene);
        history.forget_load();
        volumes.drop();
        throw ContentLost(error.code, fmt::format("The machine was started again, but its content "
                                                  "cannot be restored: {}",
                                                  error.what()));
    }
}

void Session::scale(const NodeChange& change) {
    if (volumes.has_volume() && volumes.volume().stored) {
        // The GPs read the files again. The machine continues if they cannot.
        check_unchanged(*volumes.volume().stored, volumes.volume().source);
    }
    MachinePort& machine = conversation.machine();
    const Scene before = scene;
    bool has_new_nodes = false;
    std::string reason;
    try {
        machine.start_again(change);
        has_new_nodes = true;
        begin_again(before);
        return;
    } catch (const MachineError& error) {
        if (error.is_interruption) {
            throw;
        }
        reason = error.what();
    } catch (const RequestError& error) {
        if (!has_new_nodes) {
            throw;  // The machine continues.
        }
        reason = error.what();
    }
    try {
        machine.start_again(has_new_nodes ? NodeChange{-change.gps, -change.renderers}
                                          : NodeChange{});
    } catch (MachineError& error) {
        error.is_final = true;  // A restart would have the new number of nodes.
        throw;
    }
    begin_again_or_drop(before);
    throw RequestError(ExitCode::failed, reason + ". The machine has its former nodes again");
}

void restore_all(Session& session, const Scene& wanted) {
    session.scene.size = wanted.size;
    session.scene.samples = wanted.samples;
    session.scene.overlay = wanted.overlay;
    session.scene.detail = wanted.detail;
    session.scene.stereo = wanted.stereo;
    restore(session, wanted);
}

}  // namespace pxpl5::host
