// The state of a job of Slurm, as `scontrol show job` prints it.
#pragma once

#include <string>

namespace pxpl5::host::serve {

struct JobState {
    enum class Phase : std::uint8_t { waits, runs, has_ended };

    Phase phase = Phase::waits;
    std::string name = {};       ///< Slurm's word: "PENDING".
    std::string reason = {};     ///< Why it waits: "Resources"; empty if Slurm names none.
    std::string start = {};      ///< Expected or actual start, local time; empty if unknown.
    std::string computers = {};  ///< "n[1-3]"; empty before the start.
    std::string output = {};     ///< Path of the job's output.
};

/// Reads the output of `scontrol show job`. A job without a state has ended, and one whose state is
/// unknown runs.
JobState parse_job_state(const std::string& printed);

/// Returns what the job does at the moment, for the user: "waits: Resources (...), ...".
std::string sentence_of(const JobState& state);

}  // namespace pxpl5::host::serve
