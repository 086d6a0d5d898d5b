// The first difference between two recorded runs, or between two executors on one run.
//
// Runs are compared at the level that does not depend on the machine's size: set-up, then frame by
// frame what is drawn, every region's programs, what came out. So the runs may be of other
// machines, and the difference is the first in the order in which one thing leads to the next:
// message, instruction, pixel, bit.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/base/answer.hpp"
#include "host/inspect/diff/executor_diff.hpp"
#include "host/inspect/record/selection.hpp"
#include "host/inspect/replay/executors.hpp"

namespace pxpl5::host::inspect {

/// An executor to compare with.
struct NamedExecutor {
    std::string name;
    MakeExecutor make;
    bool is_reference = false;  ///< isa/reference may stand in for it where that is quicker.
};
NamedExecutor named(ExecutorKind kind);

struct DiffOptions {
    Selection selection;  ///< Frames, regions, Renderers.
    /// Compared by diff_executors(); diff_runs() uses them to find the wrong run. The first is
    /// trusted.
    NamedExecutor trusted = named(ExecutorKind::reference), other = named(ExecutorKind::fast);
};

struct Difference {
    std::string level;  ///< "message", "instruction" or "pixel".
    Answer answer;
    std::uint32_t frame = 0;  ///< 0 for set-up.
    std::optional<std::uint32_t> region;
};

struct DiffReport {
    std::optional<Difference> difference;
    std::vector<std::string>
        notes;  ///< Omitted comparisons and harmless differences, a sentence each.
    std::size_t frames = 0, regions = 0;  ///< Compared.
};

/// Throws RequestError (bad_data) if the runs have no region in common.
DiffReport diff_runs(const RecordedRun& a, const RecordedRun& b, const DiffOptions& options = {});

/// Throws RequestError (bad_data) if no selected region can be executed.
DiffReport diff_executors(const RecordedRun& run, const DiffOptions& options = {});

Answer answer_of(const DiffReport& report);

/// Describes a difference of executors in a region: instruction, primitive and its provenance,
/// pixel, field, bit, both values.
Difference describe(const RecordedFrame& frame, const RecordedRegion& region,
                    const Divergence& divergence, const DiffOptions& options);

/// The instruction at `word` as assembly; "the end of the stream" behind the last one.
std::string instruction_text(renderer::Words words, std::size_t word);
/// "cell (31, 40, 17), case 0x8e, triangle 1"; empty if it was not recorded.
std::string provenance_text(const Primitive& primitive, std::uint32_t slab);

}  // namespace pxpl5::host::inspect
