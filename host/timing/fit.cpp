#include "host/timing/fit.hpp"

#include <fmt/format.h>
#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <memory>

#include "host/error.hpp"
#include "host/machine/timing_section.hpp"

namespace pxpl5::host::timing {

namespace {

constexpr double first_step = 0.1;  // In ln(value).
constexpr double tolerance = 1e-4;  // Likewise.
constexpr double least_value = 1e-6;
constexpr int most_runs = 400;
constexpr int digits = 3;

/// What the search calls: values are logarithms, so that steps are shares.
struct Search {
    Machine machine;
    std::span<const Parameter* const> fitted;
    std::vector<const PaperCase*> cases;
    const FitProgress& progress;
    int runs = 0;
    nlopt_opt optimiser = nullptr;
    std::exception_ptr failure{};  ///< Of the model: it must not pass through the optimiser.

    double sum_of_squares(std::span<const double> logarithms);
};

double square(double x) {
    return x * x;
}

double Search::sum_of_squares(std::span<const double> logarithms) {
    for (std::size_t i = 0; i < fitted.size(); ++i) {
        machine.*fitted[i]->value = std::exp(logarithms[i]);
    }
    double sum = 0;
    for (const PaperCase* each : cases) {
        const CaseTime time = time_of(machine, *each);
        sum += square(std::log(time.built_ms / each->row.paper.built_ms)) +
               square(std::log(time.rate.frames_per_s / each->row.paper.frames_per_s));
    }
    ++runs;
    if (progress) {
        progress(runs);
    }
    return sum;
}

double objective(unsigned count, const double* logarithms, double*, void* data) {
    auto& search = *static_cast<Search*>(data);
    try {
        return search.sum_of_squares({logarithms, count});
    } catch (...) {
        search.failure = std::current_exception();
        nlopt_force_stop(search.optimiser);
        return std::numeric_limits<double>::infinity();
    }
}

[[noreturn]] void refuse(const std::string& text) {
    throw RequestError(ExitCode::bad_data, "fit: " + text);
}

void check(const Search& search) {
    const std::size_t figures = 2 * search.cases.size();
    if (search.fitted.empty() || figures < search.fitted.size()) {
        refuse(fmt::format("{} parameters, at least 1, and as many figures; {} cases have {}",
                           search.fitted.size(), search.cases.size(), figures));
    }
    for (const Parameter* parameter : search.fitted) {
        const double value = search.machine.*parameter->value;
        const double least = std::max(parameter->least, least_value);
        if (!(value >= least && value <= parameter->most)) {
            refuse(fmt::format("{} is {}, must be {}..{} {} to begin with", parameter->name, value,
                               least, parameter->most, parameter->unit));
        }
    }
}

std::vector<double> minimise(Search& search) {
    const auto count = static_cast<unsigned>(search.fitted.size());
    const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> optimiser(
        nlopt_create(count < 2 ? NLOPT_LN_SBPLX : NLOPT_LN_BOBYQA, count), nlopt_destroy);
    search.optimiser = optimiser.get();
    std::vector<double> at, lower, upper;
    for (const Parameter* parameter : search.fitted) {
        at.push_back(std::log(search.machine.*parameter->value));
        lower.push_back(std::log(std::max(parameter->least, least_value)));
        upper.push_back(std::log(parameter->most));
    }
    nlopt_set_min_objective(optimiser.get(), objective, &search);
    nlopt_set_lower_bounds(optimiser.get(), lower.data());
    nlopt_set_upper_bounds(optimiser.get(), upper.data());
    nlopt_set_initial_step1(optimiser.get(), first_step);
    nlopt_set_xtol_abs1(optimiser.get(), tolerance);
    nlopt_set_maxeval(optimiser.get(), most_runs);
    double least = 0;
    const nlopt_result result = nlopt_optimize(optimiser.get(), at.data(), &least);
    if (search.failure) {
        std::rethrow_exception(search.failure);
    }
    if (result < 0 && result != NLOPT_ROUNDOFF_LIMITED) {
        refuse(fmt::format("the search ended with {}", nlopt_result_to_string(result)));
    }
    return at;
}

}  // namespace

std::vector<const Parameter*> fitted_parameters(const Topology& topology) {
    std::vector<const Parameter*> fitted;
    for (const Parameter& parameter : parameters()) {
        const TimingValue* entry = find_timing(topology.timing, parameter.name);
        if (entry != nullptr && entry->provenance == Provenance::fitted) {
            fitted.push_back(&parameter);
        }
    }
    return fitted;
}

double rounded(double value, int digits) {
    if (value == 0) {
        return 0;
    }
    const double unit = std::pow(10, std::floor(std::log10(std::abs(value))) + 1 - digits);
    return std::round(value / unit) * unit;
}

Fit fit(const Machine& machine, std::span<const Parameter* const> fitted,
        std::span<const PaperCase> cases, const FitProgress& progress) {
    Search search{machine, fitted, {}, progress, 0, nullptr, {}};
    for (const PaperCase& each : cases) {
        if (!each.row.held_back) {
            search.cases.push_back(&each);
        }
    }
    check(search);
    std::vector<double> found = minimise(search);
    Fit result{machine, {}, search.cases.size(), 0, 0};
    for (std::size_t i = 0; i < fitted.size(); ++i) {
        const double value = rounded(std::exp(found[i]), digits);
        result.values.push_back({fitted[i], machine.*fitted[i]->value, value});
        result.machine.*fitted[i]->value = value;
        found[i] = std::log(value);
    }
    const double figures = 2.0 * static_cast<double>(search.cases.size());
    result.deviation = std::sqrt(search.sum_of_squares(found) / figures);
    result.runs = search.runs;
    return result;
}

}  // namespace pxpl5::host::timing
