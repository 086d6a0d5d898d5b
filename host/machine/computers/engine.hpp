// The commands that start `pxpl5 join` on other computers.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "host/machine/topology.hpp"

namespace pxpl5::host {

/// How the key of the machine reaches a computer.
enum class KeyWay : std::uint8_t { input, munge, file };

/// The way of an engine.
KeyWay key_way_of(Engine engine);

/// `pxpl5 join` with its arguments.
struct JoinCommand {
    std::string program;    ///< Absolute path, the same on all computers.
    std::string addresses;  ///< "tcp://10.0.0.1:4711,tcp://192.168.1.1:4711".
    std::string key;        ///< Credential, or the path of a file; unused for KeyWay::input.
};

/// Begins the names of the engine's processes.
inline constexpr std::string_view engine_prefix = "engine-";

/// The name of an engine's process for one computer. A computer may be called like the process that
/// starts all of them, so its name gets a character that no name of a computer has.
inline std::string engine_process(const std::string& computer) {
    const bool is_name_of_all =
        computer == "slurm" || computer == "mpirun" || computer == "command";
    return std::string(engine_prefix) + computer + (is_name_of_all ? "+" : "");
}

/// A program that the host starts and ends.
struct EngineProcess {
    std::string name;  ///< "engine-" and the computer or the engine; names its log.
    std::vector<std::string> words;
    std::vector<std::string> env;
    bool starts_all = false;  ///< It starts all computers, not one.
};

/// Computers that shall join.
int expected_computers(const ClusterSettings& cluster);

/// The processes to start. `cluster` has the computers that may be used.
///
/// Throws RequestError (usage) if the number of computers is unknown, or if there is no program of
/// the engine in PATH.
std::vector<EngineProcess> engine_processes(const ClusterSettings& cluster,
                                            const JoinCommand& join);

/// `pxpl5 join` as a user types it on another computer.
std::string join_line(const JoinCommand& join, KeyWay way);

}  // namespace pxpl5::host
