// The pulse of a node: a cell of shared memory that the node writes and the host reads.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>

#include "ringbus/node.hpp"

namespace pxpl5::bus {

enum class Phase : std::uint8_t { waiting, receiving, working };

/// The values of a cell at one moment. A node may write anything, so no value is trusted.
struct PulseReading {
    std::uint64_t beats = 0;     ///< Beats of the node's clock; 0 before the node has started.
    std::uint64_t progress = 0;  ///< Steps of the node's loop. An idle loop takes one per second.
    std::uint64_t worked = 0;    ///< Steps that took a message or did a piece of work.
    std::uint64_t cpu_ns = 0;    ///< Processor time of the process at the last beat.
    int beater = 0;              ///< Id of the thread that beats; 0 if the node has none.
    Phase phase = Phase::waiting;
    Doing doing;
};

/// The numbers in the shared memory. One thread writes each.
struct PulseWords {
    std::atomic<std::uint64_t> beats{0}, cpu_ns{0};
    std::atomic<std::int32_t> beater{0};
    alignas(64) std::atomic<std::uint64_t> progress{0};
    std::atomic<std::uint64_t> worked{0}, work{0}, place{0};
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

/// The same, as they travel to another computer.
struct PulseNumbers {
    std::uint64_t beats = 0, progress = 0, worked = 0, cpu_ns = 0, work = 0, place = 0;
};

/// The shared memory of one pulse. No process can change its size.
class PulseCell {
  public:
    /// Makes a cell. Throws std::system_error.
    PulseCell();
    /// Maps the cell behind `fd` and closes `fd`. Throws std::system_error.
    explicit PulseCell(int fd);
    ~PulseCell();
    PulseCell(const PulseCell&) = delete;
    PulseCell& operator=(const PulseCell&) = delete;

    /// The descriptor of a made cell, for a child process; -1 after close_fd().
    int fd() const { return fd_; }
    void close_fd();

    PulseWords& words() { return *words_; }
    PulseReading read() const;
    PulseNumbers numbers() const;
    void set(const PulseNumbers& numbers);

  private:
    void map();

    int fd_;
    PulseWords* words_ = nullptr;
};

/// The node's side. One thread calls enter(). A thread of its own beats, so that a node that
/// computes for long is not taken for a stopped one.
class Pulse {
  public:
    /// Writes nothing.
    Pulse() = default;
    /// Beats every `interval_ms` into the cell behind `fd`. Throws std::system_error.
    Pulse(int fd, int interval_ms);

    /// Notes a step of the node's loop, and its phase from now on.
    void enter(Phase phase, const Doing& doing = {});

  private:
    std::unique_ptr<PulseCell> cell_;
    std::jthread beating_;  ///< Ends before the cell.
};

}  // namespace pxpl5::bus
