// The executors on which a region can be executed again, by name.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "host/inspect/record/region_walk.hpp"
#include "isa/executor.hpp"

namespace pxpl5::host::inspect {

/// `fast` is the widest vector target that this machine has.
enum class ExecutorKind : std::uint8_t { reference, fast, sse4, avx2, avx512 };

std::string_view name_of(ExecutorKind kind);

/// "reference", "fast", "sse4", "avx2", "avx512"; "both" is reference and fast; several are
/// separated by commas. Throws RequestError (usage) that names the text and what is expected, or a
/// vector target that this machine lacks.
std::vector<ExecutorKind> parse_executors(std::string_view text);

/// A new one, its pixels cleared and disabled. This machine has it.
std::unique_ptr<isa::Executor> make_executor(ExecutorKind kind);

/// The result of executing a region.
struct RegionRun {
    std::vector<std::uint32_t> pixels;  ///< Pixels read out: 128 * 128, row by row.
    std::vector<std::uint32_t> depths;  ///< Likewise, if the frame wanted them.
    isa::RunCounts counts;
};

/// Executes a region whole, as its Renderer did, on a new `executor`.
RegionRun run_region(const renderer::RegionPlan& plan, isa::Executor& executor);
/// The same for a region of a recorded frame, behind the passes before it.
RegionRun run_region(const RecordedRegion& region, isa::Executor& executor);

/// Brings the backing store of a new `executor` to what the region found there: of a pass, runs the
/// passes before. What these leave in pixel memory, the region's own programs do not look at.
void prepare(const RecordedRegion& region, isa::Executor& executor);

}  // namespace pxpl5::host::inspect
