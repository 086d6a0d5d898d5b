// Orders to an idle node, encoded in a message that the host may send to its role.
#pragma once

#include <cstdint>
#include <string>

#include "ringbus/message.hpp"

namespace pxpl5::test {

enum class Order : std::uint16_t {
    answer,     ///< VolumeReady to the host, or IoDone of an io process.
    fault,      ///< Fault to the host.
    exit_70,    ///< Ends with exit code 70, saying why.
    leave,      ///< Ends with exit code 0 without having been told to.
    abort,      ///< Ends by SIGABRT.
    chatter,    ///< chatter_messages times VolumeReady to the host.
    forbidden,  ///< FrameDone to the host, which neither GPs nor io processes may send.
    damaged,    ///< A VolumeHeader or SurfaceBuilt whose values are out of range.
    hang,       ///< Takes no further message.
    forge,      ///< VolumeReady in the name of gp-0 at the host's address, then as answer.
    start,      ///< Starts a program, which the sandbox of an io process does not allow.
};

/// The message that carries `what` to a GP.
inline bus::Payload order(Order what) {
    bus::schema::RemoveSurfaceT message;
    message.surface = static_cast<std::uint16_t>(what);
    return bus::pack(message);
}

/// The message that carries `what` to an io process.
inline bus::Payload io_order(Order what) {
    bus::schema::ReadMeshT message;
    message.path = std::to_string(static_cast<int>(what));
    return bus::pack(message);
}

inline constexpr int chatter_messages = 20'000;  // More than may wait for a session.

}  // namespace pxpl5::test
