// Executes recorded regions again and compares the results with the recording.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/base/answer.hpp"
#include "host/inspect/record/recorded_results.hpp"
#include "host/inspect/record/selection.hpp"
#include "host/inspect/replay/executors.hpp"

namespace pxpl5::host::inspect {

struct ReplayOptions {
    Selection selection;  ///< Frames, regions, Renderers.
    std::vector<ExecutorKind> executors = {ExecutorKind::fast};
    unsigned threads = 2;  ///< Regions at a time; 1 or more.
};

/// One region on one executor.
struct RegionReplay {
    std::uint32_t region = 0, renderer = 0;
    isa::RunCounts counts;
    bool compared = false;                  ///< Pixels were recorded to compare with.
    std::optional<std::string> difference;  ///< A sentence: pixel, or counts.
};

/// One frame on one executor.
struct FrameReplay {
    std::uint32_t frame = 0;
    ExecutorKind executor = ExecutorKind::fast;
    std::string pass;                               ///< See RecordedFrame::pass_text().
    std::vector<RegionReplay> regions;              ///< Ascending.
    std::optional<std::uint64_t> digest, recorded;  ///< Digests of the whole picture, if known.
    double elapsed_s = 0;

    std::size_t compared() const;
    const RegionReplay* first_difference() const;  ///< Null if all agree.
    bool agrees() const { return first_difference() == nullptr; }
};

struct ReplayReport {
    std::vector<FrameReplay> frames;
    std::vector<std::string> missing;  ///< Missing data, a sentence each.

    bool agrees() const;
    std::size_t compared() const;  ///< Regions, over frames and executors.
};

/// One line, and a second line if a region differs.
Answer answer_of(const FrameReplay& frame);
/// Missing data, and whether all comparisons agree.
Answer summary_of(const ReplayReport& report);
/// All frames and the summary.
Answer answer_of(const ReplayReport& report);

/// Replays the selected regions that were recorded. Calls `on_frame` after each frame and executor.
/// Throws RequestError (bad_data) if no region could be executed.
ReplayReport replay(const RecordedRun& run, const ReplayOptions& options,
                    const std::function<void(const FrameReplay&)>& on_frame = {});

}  // namespace pxpl5::host::inspect
