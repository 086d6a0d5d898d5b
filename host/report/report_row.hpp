// The paper's results beside ours: as a table, as fields for CSV and JSON, as a picture.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/base/command_line.hpp"
#include "host/base/reply.hpp"
#include "host/chart/plot.hpp"
#include "host/timing/simulate.hpp"

namespace pxpl5::host::report {

/// One figure three times.
struct Figure {
    double paper = 0;
    double modelled = 0;  ///< Result of the machine of 1993, from counts.
    double wall = 0;      ///< Result of this computer.
    timing::Unit limit{};
    double limit_share = 0;  ///< Share of the modelled time in which the busiest node works, 0..1.

    double error_percent() const { return (modelled / paper - 1) * 100; }
};

/// Picture sizes of modelled frames and of frames with wall time.
inline constexpr Size modelled_size{1280, 1024}, wall_size{512, 512};

/// How far a modelled figure may lie from the paper's.
inline constexpr double build_bound_percent = 20, frames_bound_percent = 15;

struct ReportRow {
    std::string name;    ///< "pelvis/skin".
    std::string source;  ///< The loaded file, folder or phantom.
    bool held_back = false;
    std::int64_t paper_triangles = 0, triangles = 0;
    Figure build_ms, frames_per_s;
    std::string build_reason, frames_reason;  ///< Why a figure lies where it does.

    bool build_within() const;
    bool frames_within() const;
};

/// The table, and a sentence for each figure beyond its bound.
std::string table_of(const std::vector<ReportRow>& rows);

/// Explains columns. `drawn_by` and `modelled` are texts of size_text().
struct Footnote {
    std::string modelled, drawn_by;
};
std::string text_of(const Footnote& footnote);

Fields fields_of(const ReportRow& row);

/// Two plots: surface built in, frames/s.
std::vector<Plot> plots_of(const std::vector<ReportRow>& rows);

}  // namespace pxpl5::host::report
