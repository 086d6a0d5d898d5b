// The batch script of a job of Slurm that runs `pxpl5 serve`, and the command line that submits it.
#pragma once

#include <string>
#include <vector>

namespace pxpl5::host::serve {

/// A job that `serve` submits.
struct JobOptions {
    std::vector<std::string> words;   ///< The user's command line after `serve`.
    int nodes = 0;                    ///< Computers; 0: as many as the site gives.
    std::vector<std::string> sbatch;  ///< Further options of sbatch: "--partition=gpu".
};

/// Returns the command line of sbatch, which reads the script from standard input. Throws
/// RequestError (usage) for a word that is no option, because sbatch would take it for a file.
///
/// time_limit  In the forms of Slurm; empty: the limit of the site.
std::vector<std::string> sbatch_words(const JobOptions& job, const std::string& time_limit);

/// Returns host/slurm-session.sbatch with the user's words in place of its arguments. Options for
/// the job itself are left out.
///
/// program  Absolute path of pxpl5.
std::string job_script(const JobOptions& job, const std::string& program);

}  // namespace pxpl5::host::serve
