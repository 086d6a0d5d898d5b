// pxpl5 report: the paper's results table, run again; the model's sensitivity, fit and scaling.
#pragma once

#include <string>
#include <vector>

#include "host/machine/topology.hpp"
#include "host/session/session.hpp"
#include "host/timing/cluster/parameters.hpp"

namespace pxpl5::host::report {

struct ReportOptions {
    bool paper = false, scaling = false;
    bool cluster = false;                   ///< With scaling: computers of today.
    timing::ClusterOptions computers{};     ///< Their parameters.
    bool sensitivity = false, fit = false;  ///< With the paper's table.
    bool json = false;
    std::vector<std::string> rows;  ///< By name; all if empty.
    std::string data;               ///< Folder of real volumes; none if empty.
    std::string csv, picture;       ///< Files to write; none if empty.
    std::string pictures;           ///< Folder for the surfaces' pictures; none if empty.
};

/// Throws RequestError for options that do not go together, rows, folders and files that are not
/// there: before any machine is launched.
void check(const ReportOptions& options);

/// Measures the rows with `session` and prints what the options ask for.
///
/// modelled   The machine that is modelled.
/// drawn_by   The one of the session, as size_text() says it.
/// Throws     RequestError, MachineError.
void run_report(Session& session, const ReportOptions& options, const Topology& modelled,
                const std::string& drawn_by);

}  // namespace pxpl5::host::report
