// The batch script of a job of Slurm that runs `pxpl5 serve`, and the command lines of Slurm.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace pxpl5::host::serve {

/// A job that `serve` submits.
struct JobOptions {
    std::vector<std::string> words;   ///< The user's command line after `serve`.
    int nodes = 0;                    ///< Computers; 0: as many as the site gives.
    std::vector<std::string> sbatch;  ///< Further options of sbatch: "--partition=gpu".
};

/// Returns `words` without these options, each of which has a value: "--port 80", "--port=80".
std::vector<std::string> words_without(const std::vector<std::string>& words,
                                       std::span<const std::string_view> options);

/// Returns the command line of sbatch, which reads the script from standard input. Throws
/// RequestError (usage) for a word that is no option, because sbatch would take it for a file.
///
/// time_limit  In the forms of Slurm; empty: the limit of the site.
std::vector<std::string> sbatch_words(const JobOptions& job, const std::string& time_limit);

/// A job that Slurm has accepted.
struct SubmittedJob {
    std::string id;       ///< Digits.
    std::string cluster;  ///< Empty: the cluster of this computer.
};

/// Reads the output of `sbatch --parsable`: "12" or "12;cluster" in the last line that is not
/// empty. A wrapper of the site may print other lines first. Empty if that line is no job.
std::optional<SubmittedJob> parse_submitted(const std::string& printed);

/// Returns the words for a command of Slurm about the job: `words` and the id, for its cluster.
std::vector<std::string> slurm_words(const SubmittedJob& job, std::vector<std::string> words);

/// Returns host/slurm-session.sbatch with the user's words in place of its arguments. Options for
/// the job itself are left out.
///
/// program  Absolute path of pxpl5.
std::string job_script(const JobOptions& job, const std::string& program);

}  // namespace pxpl5::host::serve
