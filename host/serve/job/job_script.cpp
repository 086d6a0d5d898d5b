#include "host/serve/job/job_script.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string_view>

#include "host/base/error.hpp"
#include "host/serve/director/shell_word.hpp"
#include "host/serve/job/slurm_session.hpp"

namespace pxpl5::host::serve {

namespace {

/// Options with a value that the program in the job does not get: the job has them, or the script.
constexpr std::array<std::string_view, 4> options_of_job{"--nodes", "--sbatch-option",
                                                         "--time-limit", "--engine"};

}  // namespace

std::vector<std::string> words_without(const std::vector<std::string>& words,
                                       std::span<const std::string_view> options) {
    std::vector<std::string> kept;
    for (std::size_t i = 0; i < words.size(); ++i) {
        if (words[i] == "--") {  // No option follows.
            kept.insert(kept.end(), words.begin() + static_cast<std::ptrdiff_t>(i), words.end());
            break;
        }
        const std::size_t equals = words[i].find('=');
        if (std::ranges::find(options, words[i].substr(0, equals)) == options.end()) {
            kept.push_back(words[i]);
        } else if (equals == std::string::npos) {
            ++i;  // Its value is the next word.
        }
    }
    return kept;
}

std::vector<std::string> sbatch_words(const JobOptions& job, const std::string& time_limit) {
    std::vector<std::string> words{"sbatch", "--parsable"};
    if (job.nodes > 0) {
        words.push_back(fmt::format("--nodes={}", job.nodes));
    }
    if (!time_limit.empty()) {
        words.push_back("--time=" + time_limit);
    }
    for (const std::string& option : job.sbatch) {
        if (!option.starts_with("-")) {
            throw RequestError(
                ExitCode::usage,
                fmt::format("--sbatch-option '{0}' is no option of sbatch, which begins with '-'. "
                            "Give one word, for example --sbatch-option=--partition=gpu",
                            option));
        }
        words.push_back(option);
    }
    return words;
}

std::optional<SubmittedJob> parse_submitted(const std::string& printed) {
    constexpr std::string_view blanks = " \t\r\n", digits = "0123456789";
    constexpr std::string_view letters =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-._";
    const std::size_t end = printed.find_last_not_of(blanks);
    if (end == std::string::npos) {
        return std::nullopt;
    }
    const std::string text = printed.substr(0, end + 1);
    const std::string line = text.substr(text.rfind('\n') + 1);  // npos + 1 is 0.
    const std::size_t split = std::min(line.find(';'), line.size());
    SubmittedJob job{line.substr(0, split), line.substr(std::min(split + 1, line.size()))};
    const bool has_cluster = !job.cluster.empty() && job.cluster.front() != '-' &&
                             job.cluster.find_first_not_of(letters) == std::string::npos;
    if (job.id.empty() || job.id.find_first_not_of(digits) != std::string::npos ||
        (split < line.size() && !has_cluster)) {
        return std::nullopt;
    }
    return job;
}

std::vector<std::string> slurm_words(const SubmittedJob& job, std::vector<std::string> words) {
    if (!job.cluster.empty()) {
        words.insert(words.begin() + 1, {"-M", job.cluster});
    }
    words.push_back(job.id);
    return words;
}

std::string job_script(const JobOptions& job, const std::string& program) {
    constexpr std::string_view begin = "set -euo pipefail\n";
    std::string set = "set --";
    for (const std::string& word : words_without(job.words, options_of_job)) {
        set += " " + shell_word(word);
    }
    set += fmt::format("\nPXPL5={}\n", shell_word(program));
    // The site may give the job another environment, and both must look for one state folder.
    if (const char* const state = std::getenv("XDG_STATE_HOME"); state != nullptr) {
        set += fmt::format("export XDG_STATE_HOME={}\n", shell_word(state));
    }
    std::string script(slurm_session);
    return script.insert(script.find(begin) + begin.size(), set);
}

}  // namespace pxpl5::host::serve
