// A session with a machine: a scene, and the parts that load, extract, draw and export it.
#pragma once

#include <any>

#include "host/session/conversation.hpp"
#include "host/session/exports.hpp"
#include "host/session/frames.hpp"
#include "host/session/history.hpp"
#include "host/session/io_requests.hpp"
#include "host/session/meshes.hpp"
#include "host/session/nodes.hpp"
#include "host/session/surfaces.hpp"
#include "host/session/volumes.hpp"

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
          frames(conversation, scene, volumes, nodes),
          meshes(conversation, scene, volumes),
          surfaces(conversation, scene, volumes, meshes, frames),
          exports(io, scene, meshes) {}
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    Scene scene;
    LoadSettings load_settings;
    History history;  ///< The commands that were run.
    std::any asked;   ///< Values that a higher layer keeps between questions.

    Conversation conversation;
    IoRequests io;
    Nodes nodes;
    Volumes volumes;
    Frames frames;
    Meshes meshes;
    Surfaces surfaces;
    Exports exports;
};

}  // namespace pxpl5::host
