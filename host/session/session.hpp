// A session with a machine: a scene, and the parts that load, extract, draw and export it.
#pragma once

#include <algorithm>
#include <any>
#include <functional>
#include <string>

#include "host/base/command_descriptor.hpp"
#include "host/session/conversation.hpp"
#include "host/session/exports.hpp"
#include "host/session/frames.hpp"
#include "host/session/history/history.hpp"
#include "host/session/io_requests.hpp"
#include "host/session/meshes.hpp"
#include "host/session/nodes.hpp"
#include "host/session/recovery.hpp"
#include "host/session/surfaces.hpp"
#include "host/session/time_series.hpp"
#include "host/session/volumes.hpp"
#include "host/session/voxels.hpp"

namespace pxpl5::host {

/// The parts of one session. Every operation of a part waits for its result. A part throws
/// RequestError for a request that fails, also with a node's Fault, and MachineError after the
/// death of a process.
struct Session {
    explicit Session(MachinePort& machine)
        : conversation(machine),
          io(conversation),
          nodes(conversation),
          volumes(conversation, io, scene, load_settings,
                  [this] {
                      surfaces.forget_reports();
                      frames.forget_content();
                  }),
          voxels(conversation, volumes),
          frames(conversation, scene, volumes, nodes),
          meshes(conversation, scene, volumes),
          surfaces(conversation, scene, volumes, meshes, frames),
          exports(io, scene, meshes) {
        machine.name_surfaces([this](std::uint32_t id) {
            const auto known = std::ranges::find(scene.surfaces, id, &Surface::id);
            return known == scene.surfaces.end() ? std::string() : known->name;
        });
    }
    /// Restores content, surfaces and scene as `wanted`, after the machine has been started again.
    /// Throws RequestError as Volumes::give_again().
    void begin_again(const Scene& wanted);
    /// The same. If the content cannot be restored, drops it and throws ContentLost.
    void begin_again_or_drop(const Scene& wanted);
    /// Adds or retires GPs and Renderers, and restores everything. Throws RequestError for a count
    /// out of range (usage), for a file that the GPs read and that has changed (bad_data; then the
    /// machine continues), and if the machine cannot start or cannot hold the content with the
    /// new nodes (failed): then it has its former nodes.
    void scale(const NodeChange& change);
    ~Session() { conversation.machine().name_surfaces({}); }
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    Scene scene;
    LoadSettings load_settings;
    History history;  ///< The commands that were run.
    /// Throws RequestError for a command that may not be run here, also from a script. May be
    /// empty.
    std::function<void(const CommandDescriptor&, const Arguments&)> check_command;
    /// Called with what a load has opened, and with an empty text when that is lost. May be empty.
    std::function<void(const std::string&)> tell_opened;
    /// Called after each picture of a command that draws many: how many are drawn, and of how many.
    /// May be empty.
    std::function<void(int done, int total)> tell_pictures;
    std::any asked;  ///< Values that a higher layer keeps between questions.

    Conversation conversation;
    IoRequests io;
    Nodes nodes;
    Volumes volumes;
    TimeSeries series{volumes};
    Voxels voxels;
    Frames frames;
    Meshes meshes;
    Surfaces surfaces;
    Exports exports;
    Recovery recovery{*this};
};

}  // namespace pxpl5::host
