// How the credentials of a machine reach other computers.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "host/machine/topology.hpp"
#include "ringbus/zmq/credentials.hpp"

namespace pxpl5::host {

/// A new key for the machines of a session. Throws RequestError (unavailable) without CURVE.
bus::Credentials make_key();

/// The key of a machine: that of the user's key file, or a new one. Throws RequestError (usage) as
/// read_key_file(), and if the machine cannot use the key file.
bus::Credentials machine_key(const ClusterSettings& cluster, bus::Protection protection);

/// One line that parse_key() reads. Whoever has it can take part in the machine.
std::string key_text(const bus::Credentials& credentials);

/// Throws RequestError (usage) naming `source` if the text is no key.
bus::Credentials parse_key(std::string_view text, const std::string& source);

/// Writes the key to a new file that only this user can read. Throws RequestError (failed).
void write_key_file(const std::filesystem::path& file, const bus::Credentials& credentials);

/// Throws RequestError (usage) if the file cannot be read, or if others can read it. A file of root
/// with mode 0440, as Kubernetes mounts a Secret, is accepted.
bus::Credentials read_key_file(const std::filesystem::path& file);

/// Reads the key's line from descriptor 0, within `limit_ms`. Throws RequestError.
bus::Credentials read_key_from_input(int limit_ms);

/// A munge credential of the key that only this user can open, once on each computer. Throws
/// RequestError (unavailable) with the words of munge.
std::string munge_credential(const bus::Credentials& credentials);

/// Opens a munge credential. Throws RequestError (unavailable) with the words of unmunge.
bus::Credentials open_munge_credential(const std::string& credential);

}  // namespace pxpl5::host
