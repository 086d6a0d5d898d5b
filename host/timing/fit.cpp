#include "host/timing/fit.hpp"

#include <fmt/format.h>
#include <nlopt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <exception>
#include <limits>
#include <memory>

#include "host/base/error.hpp"
#include "host/machine/timing_section.hpp"

namespace pxpl5::host::timing {

namespace {

constexpr double first_step = 0.1;  // In ln(value).
constexpr double probe_step = 0.05;
constexpr double tolerance = 1e-3;  // Likewise.
constexpr double least_value = 1e-6;
constexpr double least_gain = 0.01;  // Share of the sum of squares that a restart must gain.
constexpr int most_runs = 400;
constexpr int digits = 3;

/// A figure of all cases.
enum class Figure : std::uint8_t { built, rate };
constexpr std::array figures = {Figure::built, Figure::rate};

/// ln(modelled / paper).
double deviation_of(const Machine& machine, const PaperCase& each, Figure figure) {
    const PaperResult& paper = each.row.paper;
    return figure == Figure::built
               ? std::log(built_ms(build_of(machine, each)) / paper.built_ms)
               : std::log(frame_rate(machine, each.frame).frames_per_s / paper.frames_per_s);
}

/// The function of the search. Values are logarithms, so that steps are ratios.
struct Search {
    Machine machine;
    std::vector<const Parameter*> fitted;
    std::vector<Figure> figures;
    std::span<const PaperCase* const> cases;
    const FitProgress& progress;
    int& runs;
    nlopt_opt optimizer = nullptr;
    std::exception_ptr
        failure{};  ///< The model's exception; it must not pass through the optimizer.

    double sum_of_squares(std::span<const double> logarithms);
};

double Search::sum_of_squares(std::span<const double> logarithms) {
    for (std::size_t i = 0; i < fitted.size(); ++i) {
        machine.*fitted[i]->value = rounded(std::exp(logarithms[i]), digits);
    }
    double sum = 0;
    for (const PaperCase* each : cases) {
        for (const Figure figure : figures) {
            const double deviation = deviation_of(machine, *each, figure);
            sum += deviation * deviation;
        }
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
        nlopt_force_stop(search.optimizer);
        return std::numeric_limits<double>::infinity();
    }
}

[[noreturn]] void refuse_fit(const std::string& text) {
    throw RequestError(ExitCode::bad_data, "fit: " + text);
}

void check(const Machine& machine, std::span<const Parameter* const> fitted,
           std::size_t case_count) {
    const std::size_t figure_count = figures.size() * case_count;
    if (fitted.empty() || figure_count < fitted.size()) {
        refuse_fit(fmt::format("{} parameters, at least 1, and as many figures; {} cases have {}",
                               fitted.size(), case_count, figure_count));
    }
    for (const Parameter* parameter : fitted) {
        const double value = machine.*parameter->value;
        const double least = std::max(parameter->least, least_value);
        if (!(value >= least && value <= parameter->most)) {
            refuse_fit(fmt::format("{} is {}, must be {}..{} {} to begin with", parameter->name,
                                   value, least, parameter->most, parameter->unit));
        }
    }
}

/// Whether a figure of any case changes with the parameter.
bool matters(Machine machine, const Parameter& parameter, Figure figure,
             std::span<const PaperCase* const> cases) {
    Machine other = machine;
    other.*parameter.value *= 1 + probe_step;
    return std::ranges::any_of(cases, [&](const PaperCase* each) {
        return deviation_of(machine, *each, figure) != deviation_of(other, *each, figure);
    });
}

/// Parameters that are fitted together.
struct Group {
    std::vector<const Parameter*> fitted;
    std::vector<Figure> figures;
};

/// Parameters of builds and those of rates apart, so that the one do not blur the other; all
/// together if one is of both.
std::vector<Group> groups_of(const Machine& machine, std::span<const Parameter* const> fitted,
                             std::span<const PaperCase* const> cases) {
    Group built{{}, {Figure::built}}, rate{{}, {Figure::rate}};
    bool are_apart = true;
    for (const Parameter* parameter : fitted) {
        const bool of_build = matters(machine, *parameter, Figure::built, cases);
        const bool of_rate = matters(machine, *parameter, Figure::rate, cases);
        if (!of_build && !of_rate) {
            refuse_fit(fmt::format("no figure changes with {}", parameter->name));
        }
        are_apart = are_apart && of_build != of_rate;
        (of_build ? built : rate).fitted.push_back(parameter);
    }
    if (!are_apart) {
        return {{{fitted.begin(), fitted.end()}, {Figure::built, Figure::rate}}};
    }
    std::vector<Group> groups = {built, rate};
    std::erase_if(groups, [](const Group& group) { return group.fitted.empty(); });
    return groups;
}

/// Leaves the values that it finds in search.machine.
void minimize(Search& search) {
    const auto count = static_cast<unsigned>(search.fitted.size());
    const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> optimizer(
        nlopt_create(count < 2 ? NLOPT_LN_SBPLX : NLOPT_LN_BOBYQA, count), nlopt_destroy);
    search.optimizer = optimizer.get();
    std::vector<double> at, lower, upper;
    for (const Parameter* parameter : search.fitted) {
        at.push_back(std::log(search.machine.*parameter->value));
        lower.push_back(std::log(std::max(parameter->least, least_value)));
        upper.push_back(std::log(parameter->most));
    }
    nlopt_set_min_objective(optimizer.get(), objective, &search);
    nlopt_set_lower_bounds(optimizer.get(), lower.data());
    nlopt_set_upper_bounds(optimizer.get(), upper.data());
    nlopt_set_initial_step1(optimizer.get(), first_step);
    nlopt_set_xtol_abs1(optimizer.get(), tolerance);
    nlopt_set_maxeval(optimizer.get(), most_runs);
    // A rate has steps, in which a search can stay: it begins again where it has ended.
    // What is hardly better than where it began is not worth a move.
    for (double before = search.sum_of_squares(at); search.runs < most_runs;) {
        std::vector<double> next = at;
        double least = 0;
        const nlopt_result result = nlopt_optimize(optimizer.get(), next.data(), &least);
        if (search.failure) {
            std::rethrow_exception(search.failure);
        }
        if (result < 0 && result != NLOPT_ROUNDOFF_LIMITED) {
            refuse_fit(fmt::format("the search ended with {}", nlopt_result_to_string(result)));
        }
        if (!(least < before * (1 - least_gain))) {
            break;
        }
        at = next;
        before = least;
    }
    for (std::size_t i = 0; i < at.size(); ++i) {
        search.machine.*search.fitted[i]->value = rounded(std::exp(at[i]), digits);
    }
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
    std::vector<const PaperCase*> used;
    for (const PaperCase& each : cases) {
        if (!each.row.held_back) {
            used.push_back(&each);
        }
    }
    check(machine, fitted, used.size());
    Fit result{machine, {}, used.size(), 0, 0};
    for (const Group& group : groups_of(machine, fitted, used)) {
        Search search{result.machine, group.fitted, group.figures, used, progress, result.runs};
        minimize(search);
        result.machine = search.machine;
    }
    for (const Parameter* parameter : fitted) {
        result.values.push_back(
            {parameter, machine.*parameter->value, result.machine.*parameter->value});
    }
    double sum = 0;
    for (const PaperCase* each : used) {
        for (const Figure figure : figures) {
            sum += std::pow(deviation_of(result.machine, *each, figure), 2);
        }
    }
    result.deviation = std::sqrt(sum / static_cast<double>(figures.size() * used.size()));
    return result;
}

}  // namespace pxpl5::host::timing
