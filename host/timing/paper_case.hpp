// The modelled times of work like the paper's.
#pragma once

#include "host/timing/counts/machine.hpp"
#include "host/timing/counts/work.hpp"
#include "host/timing/paper_rows.hpp"
#include "host/timing/simulate.hpp"

namespace pxpl5::host::timing {

/// A row with what it asks of a machine.
struct PaperCase {
    PaperRow row;
    VolumeWork volume;
    BuildWork build;
    FrameWork frame;
};

/// The modelled times of a row, and how far they are from the paper's.
struct CaseTime {
    StepTime build;  ///< Without loading.
    double built_ms = 0;
    Rate rate;
    double built_error_percent = 0;  ///< 100 (modelled - paper) / paper.
    double rate_error_percent = 0;
};

/// Loads the volume and builds the surface: the build's time, ms, and use.
/// Throws RequestError (bad_data) as simulate() does.
StepTime build_of(const Machine& machine, const PaperCase& paper_case);
double built_ms(const StepTime& build);

/// build_of(), then the frame shown over and over.
CaseTime time_of(const Machine& machine, const PaperCase& paper_case);

/// Deviation of a modelled value from a stated one that is not 0.
double error_percent(double modelled, double stated);

}  // namespace pxpl5::host::timing
