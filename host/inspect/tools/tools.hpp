// The inspection tools: the options of each, and the function that runs it.
//
// Every function returns the exit code and throws RequestError. cli.cpp declares the options.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/base/text_output.hpp"
#include "host/inspect/record/selection.hpp"
#include "host/timing/cluster/parameters.hpp"

namespace pxpl5::host::inspect {

/// Options of every tool that reads a recorded run.
struct RunOptions {
    std::string run{};          ///< See find_run().
    SelectionText selection{};  ///< The parts of the run that the tool obeys.
    std::string output{};       ///< File; empty: standard output.
    bool json = false;
};

// Listing.

int trace_ls(const RunOptions& options);

struct DumpOptions : RunOptions {
    static constexpr std::uint64_t default_lines = 2000;
    std::vector<int> pixel{};  ///< Empty, or x and y in the picture.
    std::uint64_t lines = default_lines;
    bool all = false, instructions = false;
};
int trace_dump(const DumpOptions& options);

struct StatsOptions : RunOptions {
    bool csv = false;
};
/// Returns 1 if the counts differ from the counts that the Renderers reported.
int trace_stats(const StatsOptions& options);

struct ExportOptions : RunOptions {
    /// Viewers of timelines get slow, or fail, above a million events.
    static constexpr std::uint64_t default_events = 500'000;
    std::string chrome{};    ///< File of the timeline.
    std::string streams{};   ///< Folder for assembly files.
    std::string messages{};  ///< "json" or "csv".
    std::uint64_t events = default_events;
};
int trace_export(const ExportOptions& options);

// Replaying.

struct ReplayTool : RunOptions {
    std::string executor = "fast";
    unsigned threads = 2;
};
/// Returns 0 if every comparison agrees, 1 otherwise.
int trace_replay(const ReplayTool& tool);

struct DiffTool : RunOptions {
    std::string other{};      ///< Second run; empty: two executors are compared on the first run.
    std::string executors{};  ///< "trusted,other"; reference,fast if empty.
};
/// Returns 0 if nothing differs, 1 otherwise.
int trace_diff(const DiffTool& tool);

struct ShrinkTool : RunOptions {  ///< `run` is a run or an assembly file.
    std::string executors = "reference,fast";
    std::string pixel{};        ///< "X,Y", of the picture (run) or of the region (program).
    std::string field = "rgb";  ///< A name of the region's layout, or m8:24.
    std::string is{};           ///< Value of the pixel's field; empty: the value at the end.
};
int trace_shrink(const ShrinkTool& tool);

// Stepping and maps.

struct StepOptions : RunOptions {
    std::vector<std::string> commands{};  ///< Separated by ';'; instead of standard input.
};
/// Returns 0, or the exit code of the command that failed and ended the script.
int trace_step(const StepOptions& options);

struct MapOptions : RunOptions {
    std::string map{};  ///< Name of the map; empty: `run` is the name.
    bool raw = false;   ///< Numbers as CSV.
    bool grid = false;  ///< Lines between regions.
};
int trace_map(const MapOptions& options);

// Questions.

struct PixelOptions : RunOptions {
    std::optional<int> x{}, y{};
    std::optional<std::uint32_t> frame{};
};
int run_why(const PixelOptions& options);

struct WhyNotTool : PixelOptions {
    std::string cell{};
    std::optional<std::uint32_t> surface{};
    std::optional<int> triangle{};
};
/// Returns 1 if data are missing and no verdict is possible.
int run_why_not(const WhyNotTool& tool);

struct ModelOptions : RunOptions {
    std::optional<std::string> topology{};
    std::vector<std::string> overrides{};  ///< --set.
    std::vector<std::string> sweeps{};     ///< "gp.count=1..64".
    std::string csv{}, plot{};             ///< Files; empty for none.
    // Computers of today instead of the machine of 1993.
    std::string cluster{};  ///< "3" or "1..256*2".
    timing::ClusterOptions computers{};
};
int run_model(const ModelOptions& options);

// Programs.

struct AsmOptions {
    std::string file{}, output{};  ///< A file gets binary words, standard output hexadecimal text.
    std::vector<std::string> parameters{};  ///< "name=value".
    bool hex = false;                       ///< The file gets hexadecimal text, too.
};
int assemble_tool(const AsmOptions& options);

struct DisOptions {
    std::string file{}, output{};
    bool numbered = false, hex = false, binary = false;
};
int disassemble_tool(const DisOptions& options);

struct ExecOptions {
    std::vector<std::string> programs{};  ///< Assembly, or one conformance case; run in this order.
    std::vector<std::string> parameters{}, init{}, prints{};
    std::string executor = "reference", window = "0..15,0..7", pixel{}, picture{}, output{};
    bool hex = false, is_signed = false;
};
/// Runs the programs and writes the report to `output`. Returns 1 if a program stopped early, if
/// executors differ, or if the outcome of a case is not the expected one.
int execute(const ExecOptions& options, TextOutput& output);
int execute_tool(const ExecOptions& options);

}  // namespace pxpl5::host::inspect
