// Job queue: the order in which a GP works.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "gp_firmware/node/jobs.hpp"

namespace pxpl5::gp {

inline constexpr std::size_t max_jobs = 16384;  ///< A GP refuses messages while this many wait.

/// Keeps jobs in the order of arrival, with three exceptions. An extraction replaces older ones of
/// the same surface and precedes the frames that show it. A frame waits until the revisions that it
/// shows have been announced. A measurement comes after all other jobs.
class JobQueue {
  public:
    void add(Job job) { jobs_.push_back(std::move(job)); }

    /// Notes that `revision` of a surface has been requested. Frames wait for an announced surface,
    /// because BeginFrame comes from another node than SetSurface and may overtake it.
    void announce(std::uint16_t surface, std::uint32_t revision) { announced_[surface] = revision; }
    void add_extraction(ExtractJob job);

    /// No frame waits for a removed surface: the host removes a surface whose revision was refused.
    void add_removal(std::uint16_t surface);

    void set_measurement(MeasureJob job) { measurement_ = std::move(job); }
    /// Removes the measurement and returns it, if there is one: its answer is still owed.
    std::optional<Job> drop_measurement() { return std::exchange(measurement_, std::nullopt); }

    /// Removes the question about voxels and returns it, if one waits: its answer is still owed.
    std::optional<Job> drop_voxels();

    /// Returns the next job; null if no job is left, or if the next one is a frame that waits.
    Job* front();
    /// Removes the job that front() returned.
    void pop();
    /// Removes all jobs and announcements. Returns the frames, meshes, measurements and voxels
    /// among the jobs, because other nodes count their answers.
    std::vector<Job> clear();

    bool empty() const { return jobs_.empty() && !measurement_; }
    bool is_full() const { return jobs_.size() >= max_jobs; }
    std::size_t size() const { return jobs_.size() + (measurement_ ? 1 : 0); }

  private:
    bool awaits_surface(const Job& job) const;

    std::deque<Job> jobs_;
    std::optional<Job> measurement_;
    std::map<std::uint16_t, std::uint32_t> announced_;  ///< Newest revision of each surface.
};

}  // namespace pxpl5::gp
