// `pxpl5 join`: lets this computer take part in the machine of another one.
#pragma once

#include <string>

namespace pxpl5::host {

struct JoinOptions {
    std::string addresses;  ///< "tcp://10.0.0.1:4711,tcp://192.168.1.1:4711": of one host.
    std::string name;       ///< For the host; empty: the name of this computer.
    /// Where the key is; exactly one of the three.
    bool key_from_input = false;
    std::string key_file, munge;
    /// Time for the host to start and to answer at any of its addresses.
    int wait_s = 10;
    /// Takes part in the next machine at the same addresses when one has ended, within `wait_s`.
    bool again = false;
};

/// Joins the host's machine, starts the processes that the host asks for and watches them. Returns
/// the exit code: 0 after the host's order to end, 128 + signal after a signal, 69 if the host is
/// gone or standard input, where the key came from, was closed. With `again`, the code of the last
/// machine. No process is left.
///
/// Throws RequestError and MachineError, if the host cannot be reached or refuses this computer.
int join_machine(const JoinOptions& options);

}  // namespace pxpl5::host
