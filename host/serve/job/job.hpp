// `pxpl5 serve --engine slurm` on a login computer: a job of its own, followed to its end.
#pragma once

#include <filesystem>
#include <string>

#include "host/machine/topology.hpp"
#include "host/serve/job/job_script.hpp"

namespace pxpl5::host::serve {

/// Returns whether `serve` submits itself: with engine slurm, outside of a job, and without
/// computers that are named or counted. Throws RequestError (usage) if it does not and `job` has
/// options for a job.
bool is_submitted(const JobOptions& job, const ClusterSettings& cluster);

/// Submits a job that runs `serve`, says what the job waits for, and prints the addresses of the
/// page when the session is up. Then follows the job to its end. SIGINT and SIGTERM cancel the job.
/// Returns the exit code.
///
/// base        The parent of the run folders, which the computers of the job share.
/// time_limit  See parse_duration(); empty: the limit of the site.
/// Throws RequestError: usage for wrong options, unavailable with the words of Slurm if the job is
/// refused, or ends before its page is up, or fails later.
int serve_in_job(const JobOptions& job, const std::filesystem::path& base,
                 const std::string& time_limit);

}  // namespace pxpl5::host::serve
