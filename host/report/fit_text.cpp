#include "host/report/fit_text.hpp"

#include <fmt/format.h>

#include <cmath>

#include "host/base/text_table.hpp"

namespace pxpl5::host::report {

std::string text_of(const timing::Fit& fit, std::span<const timing::PaperCase> cases,
                    std::span<const std::string> names) {
    std::string used, held_back;
    for (std::size_t i = 0; i < cases.size(); ++i) {
        std::string& list = cases[i].row.held_back ? held_back : used;
        list += (list.empty() ? "" : ", ") + names[i];
    }
    std::vector<TableRow> rows;
    for (const timing::FittedValue& value : fit.values) {
        rows.push_back({std::string(value.parameter->name), std::string(value.parameter->unit),
                        fmt::format("{:g}", value.start), fmt::format("{:g}", value.value),
                        fmt::format("{:+.2f}", (value.value / value.start - 1) * 100)});
    }
    constexpr double to_percent = 100;
    return fmt::format("fit: used {}; held back {}\n", used,
                       held_back.empty() ? "none" : held_back) +
           text_table({"parameter", "unit", "in the file", "fits best", "difference, %"}, rows, 2) +
           fmt::format(
               "deviation of what was used, root of the mean square: {:.1f} %; {} runs of "
               "the model\n",
               std::expm1(fit.deviation) * to_percent, fit.runs);
}

Fields fields_of(const timing::Fit& fit) {
    std::vector<Fields> values;
    for (const timing::FittedValue& value : fit.values) {
        values.push_back({{"parameter", std::string(value.parameter->name)},
                          {"unit", std::string(value.parameter->unit)},
                          {"in_file", value.start},
                          {"fitted", value.value}});
    }
    return {{"values", values},
            {"rows_used", static_cast<std::int64_t>(fit.cases_used)},
            {"deviation", fit.deviation},
            {"runs", std::int64_t{fit.runs}}};
}

}  // namespace pxpl5::host::report
