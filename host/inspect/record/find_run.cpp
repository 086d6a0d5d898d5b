#include "host/inspect/record/find_run.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <system_error>
#include <utility>
#include <vector>

#include "host/base/error.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace fs = std::filesystem;

bool is_latest(const std::string& text) {
    return text.empty() || text == "latest";
}

bool holds_trace(const fs::path& run) {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(run / "traces", ignored)) {
        if (entry.path().extension() == ".mcap") {
            return true;
        }
    }
    return false;
}

/// Says so if a later run than the chosen one was not recorded: it may be the one that is meant.
std::string newer_run_note(const fs::path& chosen) {
    fs::path newest = chosen;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(chosen.parent_path(), ignored)) {
        if (entry.is_directory() && entry.last_write_time() > fs::last_write_time(newest)) {
            newest = entry.path();
        }
    }
    return newest == chosen || holds_trace(newest)
               ? ""
               : fmt::format(" ({} is newer, but holds no trace)", newest.filename().string());
}

}  // namespace

fs::path find_run(const std::string& text, const fs::path& base) {
    if (!is_latest(text)) {
        return text;
    }
    std::vector<std::pair<fs::file_time_type, fs::path>> runs;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(base, ignored)) {
        if (entry.is_directory() && holds_trace(entry.path())) {
            // When traces were written last: a flight may be saved long after its run began.
            runs.emplace_back(fs::last_write_time(entry.path() / "traces"), entry.path());
        }
    }
    if (runs.empty()) {
        throw RequestError(ExitCode::usage,
                           fmt::format("no recorded run under {}/; name one, or record one: "
                                       "pxpl5 render ... --record full",
                                       base.string()));
    }
    return std::ranges::max(runs).second;
}

RecordedRun open_run(const std::string& text) {
    const fs::path path = find_run(text);
    if (is_latest(text)) {
        fmt::print(stderr, "run: {}{}\n", path.string(), newer_run_note(path));
    }
    return RecordedRun::open(path);
}

}  // namespace pxpl5::host::inspect
