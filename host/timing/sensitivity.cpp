#include "host/timing/sensitivity.hpp"

#include <algorithm>
#include <cmath>

namespace pxpl5::host::timing {

namespace {

std::vector<CaseTime> times_of(const Machine& machine, std::span<const PaperCase> cases) {
    std::vector<CaseTime> times;
    for (const PaperCase& each : cases) {
        times.push_back(time_of(machine, each));
    }
    return times;
}

Trial trial_of(Machine machine, const Parameter& parameter, double value,
               std::span<const PaperCase> cases, std::span<const CaseTime> before) {
    machine.*parameter.value = value;
    Trial trial{value, {}};
    const std::vector<CaseTime> after = times_of(machine, cases);
    for (std::size_t i = 0; i < cases.size(); ++i) {
        trial.changes.push_back(
            {error_percent(after[i].built_ms, before[i].built_ms),
             error_percent(after[i].rate.frames_per_s, before[i].rate.frames_per_s)});
    }
    return trial;
}

double greatest_of(const std::optional<Trial>& trial) {
    return trial ? trial->greatest_percent() : 0;
}

}  // namespace

double Trial::greatest_percent() const {
    double greatest = 0;
    for (const FigureChange& change : changes) {
        greatest =
            std::max({greatest, std::abs(change.built_percent), std::abs(change.rate_percent)});
    }
    return greatest;
}

double Sensitivity::greatest_percent() const {
    return std::max(greatest_of(lower), greatest_of(upper));
}

std::optional<double> trial_value(const Parameter& parameter, double value, int sign) {
    double trial = value * (1 + sign * sensitivity_step);
    if (parameter.whole) {
        trial = std::round(trial);
        trial = trial == value ? value + sign : trial;
    }
    const bool fits = trial != value && trial >= parameter.least && trial <= parameter.most;
    return fits ? std::optional(trial) : std::nullopt;
}

std::vector<Sensitivity> sensitivity(const Machine& machine, std::span<const PaperCase> cases,
                                     const Progress& progress) {
    const std::vector<CaseTime> before = times_of(machine, cases);
    std::vector<Sensitivity> all;
    for (const Parameter& parameter : parameters()) {
        Sensitivity one;
        one.parameter = &parameter;
        one.value = machine.*parameter.value;
        for (const int sign : {-1, 1}) {
            if (const auto value = trial_value(parameter, one.value, sign)) {
                (sign < 0 ? one.lower : one.upper) =
                    trial_of(machine, parameter, *value, cases, before);
            }
        }
        all.push_back(std::move(one));
        if (progress) {
            progress(all.size(), parameters().size());
        }
    }
    std::stable_sort(all.begin(), all.end(), [](const Sensitivity& a, const Sensitivity& b) {
        return a.greatest_percent() > b.greatest_percent();
    });
    return all;
}

}  // namespace pxpl5::host::timing
