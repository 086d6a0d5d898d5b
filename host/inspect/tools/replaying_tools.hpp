// pxpl5 trace replay, diff and shrink: what their command lines run.
#pragma once

#include <string>

#include "host/inspect/record/selection.hpp"

namespace pxpl5::host::inspect {

struct ReplayTool {
    std::string run, executor = "fast", output;
    SelectionText selection;
    unsigned threads = 2;
    bool json = false;
};
/// Returns 0 if all that could be compared agrees, 1 otherwise. Throws RequestError.
int trace_replay(const ReplayTool& tool);

struct DiffTool {
    std::string a, b;       ///< `b` may be empty: then two executors are compared on `a`.
    std::string executors;  ///< "trusted,other"; reference,fast if empty.
    std::string output;
    SelectionText selection;
    bool json = false;
};
/// Returns 0 if nothing differs, 1 otherwise. Throws RequestError.
int trace_diff(const DiffTool& tool);

struct ShrinkTool {
    std::string input;  ///< A run, or an assembly file.
    std::string executors = "reference,fast";
    std::string output;  ///< NAME.pxasm, NAME_test.cpp and NAME.pxt are written; may be empty.
    SelectionText selection;
    std::string pixel;          ///< "X,Y", of the picture (run) or of the region (program).
    std::string field = "rgb";  ///< A name of the region's layout, or m8:24.
    std::string is;             ///< Value that the pixel's field has; the trusted one's if empty.
};
/// Returns 0. Throws RequestError: failed if nothing differs.
int trace_shrink(const ShrinkTool& tool);

}  // namespace pxpl5::host::inspect
