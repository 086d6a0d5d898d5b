// Proofs that a process is a node of one machine. They are in memory only, never in a file.
#pragma once

#include <optional>
#include <string>

#include "ringbus/message.hpp"

namespace pxpl5::bus {

/// A CURVE key pair as ZeroMQ writes it: 40 characters each (Z85). All nodes of a session share it.
struct CurveKeys {
    std::string open, secret;
};

struct Credentials {
    schema::Secret secret;          ///< In the Hello of each child.
    std::optional<CurveKeys> keys;  ///< For tcp. Without them tcp is refused.
    bool allows_plain_tcp = false;  ///< Without keys: tcp without encryption.
    bool allows_network = false;    ///< tcp to other computers, too.
};

/// How a machine protects its connections.
enum class Protection : std::uint8_t {
    files,      ///< ipc: the folder of the sockets is private.
    curve,      ///< tcp, encrypted.
    plain_tcp,  ///< tcp without encryption: whoever reaches the ports can take part.
};

/// True if this libzmq has CURVE.
bool has_curve();

/// True if `keys` are a pair: the open key is that of the secret one. Requires has_curve().
bool is_pair(const CurveKeys& keys);

/// How far the connections of a machine reach.
enum class Reach : std::uint8_t { this_computer, network };

/// Makes credentials from the system's random numbers. Protection::curve requires has_curve().
Credentials make_credentials(Protection protection, Reach reach = Reach::this_computer);

/// The descriptor at which a child inherits its credentials.
inline constexpr int credentials_descriptor = 3;

/// Returns the read end of a pipe that has `credentials`, to be closed by the caller. Children get
/// it as a descriptor, because other users can read arguments and this user's programs can read
/// environments. Throws std::runtime_error.
int credentials_pipe(const Credentials& credentials);

/// Reads the credentials from a pipe and closes it. Throws std::runtime_error if the pipe has none.
Credentials inherit_credentials(int descriptor);

}  // namespace pxpl5::bus
