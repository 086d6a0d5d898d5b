// The heartbeat: finds nodes that have stopped, that are stuck, and answers that are lost.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/machine/topology.hpp"
#include "ringbus/pulse.hpp"

namespace pxpl5::host {

/// Returns the name of a surface, for example "bone"; empty if the id is unknown.
using NameOfSurface = std::function<std::string(std::uint32_t id)>;

/// Whether the node has nothing to do, and takes no message.
bool is_idle(const bus::PulseReading& pulse);
/// "while building surface 'bone' (slab 3 of 12)".
std::string work_text(const bus::PulseReading& pulse, const NameOfSurface& name_of_surface);
/// The same of an io process, which works on one request and has no surfaces.
std::string io_work_text(const bus::PulseReading& pulse);

/// A process that the heartbeat watches.
struct Watched {
    std::string name;    ///< "gp-3".
    int pid = 0;         ///< 0: the state of the process is not looked up.
    bool is_io = false;  ///< Its processor time counts as progress, because its libraries take no
                         ///< steps. A limit of their own ends processes that compute for ever.
};

/// A node that is silent for two intervals is suspect. After HeartbeatSettings::misses intervals
/// it is dead. Time in which the host itself did not look does not count, so that a host or a
/// computer that was stopped blames no node. Time in which the thread that beats waits for a
/// processor counts a tenth: a computer with too much to do blames no node either.
class Heartbeat {
  public:
    explicit Heartbeat(const HeartbeatSettings& settings) : settings_(settings) {}

    bool is_on() const { return settings_.misses > 0; }
    int interval_ms() const { return settings_.interval_ms; }
    void name_surfaces(NameOfSurface name_of_surface) {
        name_of_surface_ = std::move(name_of_surface);
    }

    /// Makes the cell of a process. Returns a descriptor for the child, which is valid until
    /// watch(). Replaces an earlier process of this name. Throws std::system_error.
    int prepare(const std::string& name);
    /// Begins to watch a prepared process. It is silent from its first beat on at the earliest.
    void watch(const Watched& process, std::int64_t now_ms);
    void forget(const std::string& name) { nodes_.erase(name); }
    /// Takes the pulse of a process on another computer.
    void take(const std::string& name, const bus::PulseNumbers& pulse);
    const bus::PulseCell* cell_of(const std::string& name) const;

    struct Finding {
        std::string name;
        std::string text;  ///< "gp-0 does not answer: last heard 10 s ago while ..."
        bool is_dead = false;
        bool is_stopped = false;  ///< By SIGSTOP.
    };
    /// Looks at all nodes, at most once per interval. Reports each suspect once.
    std::vector<Finding> look(std::int64_t now_ms);
    /// Milliseconds until the next look; -1 if the heartbeat is off.
    int due_ms(std::int64_t now_ms) const;

    /// A message has come to the host, or the host begins to wait for another answer.
    void note_answer() { quiet_ms_ = 0; }
    /// The host waits for an answer until the next look.
    void note_wait() { waits_ = true; }
    /// Time for which the host has waited although no node works: the answer is probably lost.
    std::int64_t quiet_ms() const { return quiet_ms_; }
    bool is_suspicious() const { return quiet_ms_ >= std::int64_t{2} * settings_.interval_ms; }
    bool is_lost() const { return is_suspicious() && quiet_ms_ >= settings_.silence_ms(); }

  private:
    struct Node {
        Watched process;
        std::unique_ptr<bus::PulseCell> cell;
        bus::PulseReading last{};
        std::int64_t silent_ms = 0;  ///< Since the last beat.
        std::int64_t still_ms = 0;   ///< Since the last progress.
        bool is_watched = false, is_suspect = false, is_done = false;
    };

    std::optional<Finding> judge(Node& node, std::int64_t passed_ms);

    HeartbeatSettings settings_;
    NameOfSurface name_of_surface_;
    std::map<std::string, Node> nodes_;
    std::optional<std::int64_t> looked_ms_;
    bool waits_ = false, works_ = false;  ///< Since the last look.
    std::int64_t quiet_ms_ = 0;
};

}  // namespace pxpl5::host
