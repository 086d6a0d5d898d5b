// Finds the values of the machine's fitted parameters from the paper's results.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "host/timing/counts/machine.hpp"
#include "host/timing/paper_case.hpp"

namespace pxpl5::host::timing {

/// The parameters that a topology calls fitted, in the order of parameters().
std::vector<const Parameter*> fitted_parameters(const Topology& topology);

struct FittedValue {
    const Parameter* parameter = nullptr;
    double start = 0;  ///< Value before the fit.
    double value = 0;  ///< Fitted value, to three digits.
};

struct Fit {
    Machine machine;  ///< With the fitted values.
    std::vector<FittedValue> values;
    std::size_t cases_used = 0;  ///< Cases that are not held back.
    /// Root mean square of ln(modelled / paper) over their builds and frame rates.
    double deviation = 0;
    int runs = 0;  ///< How often the model built all of them, or drew all.
};

/// Called with the number of runs so far.
using FitProgress = std::function<void(int runs)>;

/// Chooses the values of `fitted` so that the sum of ln(modelled / paper) squared, over the build
/// times and frame rates of the cases that are not held back, is least: 20 % too slow and 20 % too
/// quick weigh the same. Parameters that only builds depend on and those that only rates depend on
/// are chosen one group after the other. Without derivatives (BOBYQA, Powell 2009; one alone:
/// Subplex, Rowan 1990), from the machine's own values,
/// which stay if the sum would fall by less than 1 %.
///
/// Throws RequestError (bad_data): no parameter, fewer figures than parameters, a parameter that is
/// 0 or out of its range or changes no figure, the search fails, what simulate() refuses.
Fit fit(const Machine& machine, std::span<const Parameter* const> fitted,
        std::span<const PaperCase> cases, const FitProgress& progress = {});

/// Rounds a value to `digits` digits, for a file.
double rounded(double value, int digits);

}  // namespace pxpl5::host::timing
