#include "host/inspect/record/find_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/kernel/standard_streams.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace fs = std::filesystem;

constexpr const char* latest_recorded = "latest-recorded";

bool is_latest(const std::string& text) {
    return text.empty() || text == "latest" || text == latest_recorded;
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

/// When a run was made, or its traces were written: a flight may be saved long after the start.
fs::file_time_type time_of(const fs::path& run) {
    return fs::last_write_time(holds_trace(run) ? run / "traces" : run);
}

/// The newest run under `base`. Empty if there is none.
fs::path newest_run(const fs::path& base, bool must_be_recorded) {
    // A time_point of zero lies in the future: the epoch of the file clock is not that of Unix.
    std::pair<fs::file_time_type, fs::path> newest{fs::file_time_type::min(), {}};
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(base, ignored)) {
        if (entry.is_directory() && (!must_be_recorded || holds_trace(entry.path()))) {
            newest = std::max(newest, {time_of(entry.path()), entry.path()});
        }
    }
    return newest.second;
}

}  // namespace

fs::path find_run(const std::string& text, const fs::path& base) {
    if (!is_latest(text)) {
        return text;
    }
    const fs::path recorded = newest_run(base, true);
    if (recorded.empty()) {
        throw RequestError(ExitCode::bad_data,
                           fmt::format("no recorded run under {}/; name a run, or record one: "
                                       "pxpl5 render ... --record full",
                                       base.string()));
    }
    const fs::path newest = newest_run(base, text == latest_recorded);
    if (newest != recorded) {
        throw RequestError(
            ExitCode::bad_data,
            fmt::format("the newest run {} has no trace: run it again with --record full, or give "
                        "{} for {}",
                        newest.string(), latest_recorded, recorded.string()));
    }
    return recorded;
}

RecordedRun open_run(const std::string& text) {
    const fs::path path = find_run(text);
    if (is_latest(text)) {
        fmt::print(stderr, "run: {}\n", printable(path.string()));
    }
    return RecordedRun::open(path);
}

std::uint32_t one_frame(const RecordedRun& run, const SelectionText& text) {
    const Selection selection = parse_selection(text);
    std::vector<std::uint32_t> selected;
    for (const std::uint32_t frame : run.frames()) {
        if (selection.has_frame(frame)) {
            selected.push_back(frame);
        }
    }
    if (selected.empty()) {
        const std::vector<std::uint32_t> all = run.frames();
        throw RequestError(ExitCode::usage,
                           all.empty() ? std::string("the run has no recorded frame")
                                       : fmt::format("the run has no such frame; it has {} to {}",
                                                     all.front(), all.back()));
    }
    if (selected.size() > 1 && !selection.frames.empty()) {
        throw RequestError(ExitCode::usage, fmt::format("{} frames are selected; name one with "
                                                        "--frame, e.g. --frame {}",
                                                        selected.size(), selected.back()));
    }
    return selected.back();
}

}  // namespace pxpl5::host::inspect
