// How much each modelled figure changes with each parameter of the machine.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "host/timing/counts/machine.hpp"
#include "host/timing/paper_case.hpp"

namespace pxpl5::host::timing {

/// Change of a case's figures, in percent of what they are with the parameter as it is.
struct FigureChange {
    double built_percent = 0;  ///< Change of the time to build.
    double rate_percent = 0;   ///< Change of the frames/s.
};

/// A parameter that was tried with another value.
struct Trial {
    double value = 0;
    std::vector<FigureChange> changes;  ///< By case.
    /// The greatest change of all, without sign.
    double greatest_percent() const;
};

struct Sensitivity {
    const Parameter* parameter = nullptr;
    double value = 0;            ///< The machine's value.
    std::optional<Trial> lower;  ///< None where that would be out of range.
    std::optional<Trial> upper;
    double greatest_percent() const;
};

/// Share by which a parameter is changed.
inline constexpr double sensitivity_step = 0.2;

/// The value to try: `sign` * 20 % away; of a whole number the nearest other whole number to that.
/// None if it is out of the parameter's range, or the parameter is 0.
std::optional<double> trial_value(const Parameter& parameter, double value, int sign);

/// How far it has come: parameters that are done, and how many there are.
using Progress = std::function<void(std::size_t done, std::size_t all)>;

/// Tries every parameter 20 % lower and higher, one at a time. The parameter with the greatest
/// change comes first; ties in the order of parameters().
std::vector<Sensitivity> sensitivity(const Machine& machine, std::span<const PaperCase> cases,
                                     const Progress& progress = {});

}  // namespace pxpl5::host::timing
