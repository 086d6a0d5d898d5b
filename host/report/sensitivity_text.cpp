#include "host/report/sensitivity_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "host/base/text_table.hpp"

namespace pxpl5::host::report {

namespace {

using timing::FigureChange;
using timing::Sensitivity;
using timing::Trial;
using Figure = double FigureChange::*;

constexpr std::size_t cases_per_table = 5, most_in_words = 3, most_bars = 10;

bool is_shown(const Sensitivity& sensitivity) {
    return sensitivity.greatest_percent() >= least_shown_percent;
}

std::string change_text(double percent) {
    return std::abs(percent) < 0.05 ? "0" : fmt::format("{:+.1f}", percent);
}

std::string value_text(double from, double to) {
    return fmt::format("{:g} -> {:g}", from, to);
}

/// A line for each value that was tried; the cases from `first` on.
std::string table_of(const std::vector<Sensitivity>& list, std::span<const std::string> names,
                     std::size_t first) {
    const std::size_t last = std::min(first + cases_per_table, names.size());
    TableRow heading{"parameter, change in %", "value"};
    for (const char* figure : {"built", "f/s"}) {
        for (std::size_t i = first; i < last; ++i) {
            heading.push_back(fmt::format("{}{}", figure, i + 1));
        }
    }
    std::vector<TableRow> rows;
    for (const Sensitivity& sensitivity : list) {
        for (const std::optional<Trial>& trial : {sensitivity.lower, sensitivity.upper}) {
            if (!trial || !is_shown(sensitivity)) {
                continue;
            }
            TableRow row{std::string(sensitivity.parameter->name),
                         value_text(sensitivity.value, trial->value)};
            for (const Figure figure :
                 {&FigureChange::built_percent, &FigureChange::rate_percent}) {
                for (std::size_t i = first; i < last; ++i) {
                    row.push_back(change_text(trial->changes[i].*figure));
                }
            }
            rows.push_back(row);
        }
    }
    std::string legend;
    for (std::size_t i = first; i < last; ++i) {
        legend += fmt::format("{}{} {}", legend.empty() ? "" : ", ", i + 1, names[i]);
    }
    return legend + "\n" + text_table(heading, rows, 2);
}

/// The greatest change of a figure by this trial.
struct Greatest {
    double percent = 0;
    std::size_t index = 0;
};
Greatest greatest(const Trial& trial, Figure figure) {
    Greatest found;
    for (std::size_t i = 0; i < trial.changes.size(); ++i) {
        const double percent = trial.changes[i].*figure;
        if (std::abs(percent) > std::abs(found.percent)) {
            found = {percent, i};
        }
    }
    return found;
}

double size_of(const Sensitivity& sensitivity, Figure figure) {
    double size = 0;
    for (const std::optional<Trial>& trial : {sensitivity.lower, sensitivity.upper}) {
        size = std::max(size, trial ? std::abs(greatest(*trial, figure).percent) : 0);
    }
    return size;
}

/// The parameters, that with the greatest change of a figure first.
std::vector<const Sensitivity*> ranked(const std::vector<Sensitivity>& list, Figure figure) {
    std::vector<const Sensitivity*> all;
    for (const Sensitivity& sensitivity : list) {
        all.push_back(&sensitivity);
    }
    std::ranges::stable_sort(all, std::ranges::greater(),
                             [figure](const Sensitivity* one) { return size_of(*one, figure); });
    return all;
}

std::string in_words(const std::vector<Sensitivity>& list, std::span<const std::string> names,
                     Figure figure, std::string_view subject) {
    std::string text = fmt::format("{} most with\n", subject);
    std::size_t told = 0;
    for (const Sensitivity* one : ranked(list, figure)) {
        if (told == most_in_words || size_of(*one, figure) < least_shown_percent) {
            break;
        }
        ++told;
        text += fmt::format("  {}", one->parameter->name);
        for (const std::optional<Trial>& trial : {one->lower, one->upper}) {
            if (trial) {
                const Greatest change = greatest(*trial, figure);
                text += fmt::format(", {} {}: {} % ({})", value_text(one->value, trial->value),
                                    one->parameter->unit, change_text(change.percent),
                                    names[change.index]);
            }
        }
        text += '\n';
    }
    return text + (told == 0 ? "  no parameter\n" : "");
}

Fields fields_of(const Sensitivity& sensitivity, const Trial& trial, const std::string& name,
                 const FigureChange& change) {
    return {{"parameter", std::string(sensitivity.parameter->name)},
            {"unit", std::string(sensitivity.parameter->unit)},
            {"value", sensitivity.value},
            {"tried", trial.value},
            {"row", name},
            {"build_ms_change_percent", change.built_percent},
            {"frames_per_s_change_percent", change.rate_percent}};
}

double mean(const std::optional<Trial>& trial, Figure figure) {
    double sum = 0;
    for (const FigureChange& change : trial ? trial->changes : std::vector<FigureChange>{}) {
        sum += change.*figure;
    }
    return trial && !trial->changes.empty() ? sum / static_cast<double>(trial->changes.size()) : 0;
}

/// A whole number changes by more than a fifth: by how much is said.
std::string bar_name(const Sensitivity& one) {
    if (!one.parameter->whole) {
        return std::string(one.parameter->name);
    }
    const auto value = [](const std::optional<Trial>& trial) {
        return trial ? fmt::format("{}", trial->value) : "-";
    };
    return fmt::format("{} {}/{}/{}", one.parameter->name, value(one.lower), one.value,
                       value(one.upper));
}

ChangePlot plot_of(const std::vector<Sensitivity>& list, Figure figure, const std::string& title) {
    ChangePlot plot{title,
                    "",
                    "change in %, mean over the rows",
                    "parameter 20 % lower",
                    "parameter 20 % higher",
                    {}};
    for (const Sensitivity* one : ranked(list, figure)) {
        if (plot.changes.empty() ||
            (plot.changes.size() < most_bars && size_of(*one, figure) >= least_shown_percent)) {
            plot.changes.push_back(
                {bar_name(*one), mean(one->lower, figure), mean(one->upper, figure)});
        }
    }
    return plot;
}

}  // namespace

std::string text_of(const std::vector<Sensitivity>& list, std::span<const std::string> names) {
    std::string text =
        "sensitivity: change of each modelled figure in %, each parameter 20 % lower and higher\n";
    for (std::size_t first = 0; first < names.size(); first += cases_per_table) {
        text += table_of(list, names, first);
    }
    std::string without;
    for (const Sensitivity& sensitivity : list) {
        if (!is_shown(sensitivity)) {
            without +=
                fmt::format("{}{}", without.empty() ? "" : ", ", sensitivity.parameter->name);
        }
    }
    if (!without.empty()) {
        text += fmt::format("less than {} % of any figure: {}\n", least_shown_percent, without);
    }
    return text + in_words(list, names, &FigureChange::built_percent, "the time to build changes") +
           in_words(list, names, &FigureChange::rate_percent, "frames/s change");
}

std::vector<Fields> fields_of(const std::vector<Sensitivity>& list,
                              std::span<const std::string> names) {
    std::vector<Fields> all;
    for (const Sensitivity& sensitivity : list) {
        for (const std::optional<Trial>& trial : {sensitivity.lower, sensitivity.upper}) {
            for (std::size_t i = 0; trial && i < names.size(); ++i) {
                all.push_back(fields_of(sensitivity, *trial, names[i], trial->changes[i]));
            }
        }
    }
    return all;
}

std::vector<Plot> plots_of(const std::vector<Sensitivity>& list) {
    return {plot_of(list, &FigureChange::built_percent, "Time to build"),
            plot_of(list, &FigureChange::rate_percent, "Frames/s")};
}

}  // namespace pxpl5::host::report
