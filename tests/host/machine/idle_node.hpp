// Orders to an idle node, encoded in the surface of a RemoveSurface message.
#pragma once

#include <cstdint>

namespace pxpl5::test {

enum class Order : std::uint16_t {
    answer,   ///< VolumeReady to the host.
    fault,    ///< Fault to the host.
    exit_70,  ///< Ends with exit code 70, saying why.
    leave,    ///< Ends with exit code 0 without having been told to.
    abort,    ///< Ends by SIGABRT.
    chatter,  ///< chatter_messages times VolumeReady to the host.
};

inline constexpr int chatter_messages = 20'000;  // More than may wait for a session.

}  // namespace pxpl5::test
