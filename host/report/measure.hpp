// The rows of a report, made on a machine that is there: their counts, and their wall time.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "host/report/sources.hpp"
#include "host/session/session.hpp"
#include "host/timing/paper_case.hpp"

namespace pxpl5::host::report {

struct MeasuredCase {
    timing::PaperCase work;  ///< Its frame is of modelled_size.
    timing::FrameWork pair;  ///< Both eyes, of a Headset's size; empty if not requested.
    std::int64_t triangles = 0;
    double wall_built_ms = 0;
    double wall_frames_per_s = 0;  ///< For wall_size; 0 if not requested.
    std::string picture;           ///< The file that was written, if one was.
};

struct MeasureOptions {
    bool wall = true;    ///< Whether frames are drawn for their wall time.
    bool pairs = false;  ///< Whether a frame is drawn for both eyes.
    /// Folder for pictures; none if empty. They are shaded with smooth gradients.
    std::string pictures;
    /// Called before each row, and before its picture. done  The rows, and then the pictures,
    /// before it.
    std::function<void(std::size_t done, const Source& source)> progress;
};

/// Throws RequestError, MachineError.
std::vector<MeasuredCase> measure(Session& session, std::span<const Source> sources,
                                  const MeasureOptions& options);

}  // namespace pxpl5::host::report
