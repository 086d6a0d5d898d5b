#include "host/report/report.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <cstdio>
#include <iterator>
#include <optional>

#include "host/base/error.hpp"
#include "host/base/kernel/standard_streams.hpp"
#include "host/base/text_output.hpp"
#include "host/report/cluster_scaling.hpp"
#include "host/report/fit_text.hpp"
#include "host/report/headset_text.hpp"
#include "host/report/measure.hpp"
#include "host/report/reason.hpp"
#include "host/report/report_row.hpp"
#include "host/report/scaling.hpp"
#include "host/report/sensitivity_text.hpp"
#include "host/report/sources.hpp"
#include "host/session/pictures/write_picture.hpp"

namespace pxpl5::host::report {

namespace {

using timing::CaseTime;
using timing::Machine;
using timing::PaperCase;

/// One line on standard error that shows the progress of the work, if it is a terminal.
class Progress {
  public:
    Progress() = default;
    ~Progress() {
        if (is_shown_) {
            fmt::print(stderr, "{}", line_clearer());
        }
    }
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    void tell(const std::string& text) const {
        if (is_shown_) {
            fmt::print(stderr, "{}{}", line_clearer(), printable(text));
        }
    }

  private:
    bool is_shown_ = isatty(STDERR_FILENO) != 0;
};

/// Measured values of a report.
struct Material {
    std::vector<Source> sources;
    std::vector<MeasuredCase> cases;
    Machine machine;

    std::vector<std::string> names() const {
        std::vector<std::string> all;
        for (const Source& source : sources) {
            all.push_back(source.name);
        }
        return all;
    }
    std::vector<PaperCase> work() const {
        std::vector<PaperCase> all;
        for (const MeasuredCase& measured : cases) {
            all.push_back(measured.work);
        }
        return all;
    }
};

ReportRow row_of(const Machine& machine, const Source& source, const MeasuredCase& measured) {
    const PaperCase& work = measured.work;
    const timing::PaperResult& paper = work.row.paper;
    const CaseTime time = time_of(machine, work);
    ReportRow row{source.name,
                  source.volume,
                  work.row.held_back,
                  paper.triangles,
                  measured.triangles,
                  {},
                  {},
                  {},
                  {}};
    row.build_ms = {paper.built_ms, time.built_ms, measured.wall_built_ms, time.build.limit,
                    busiest_of(time.build.use).busiest};
    row.frames_per_s = {paper.frames_per_s, time.rate.frames_per_s, measured.wall_frames_per_s,
                        time.rate.limit, busiest_of(time.rate.use).busiest};
    row.build_reason = build_reason(machine, work.volume, work.build, time.build, paper.built_ms);
    row.frames_reason = frames_reason(machine, work.frame, time.rate);
    return row;
}

/// One kind of report, in each of its forms.
struct Output {
    std::string text;
    Fields fields;
    std::vector<Fields> lines;  ///< Lines of the CSV file.
    std::vector<Plot> plots;
};

void add_sensitivity(Output& output, const Material& material, const Progress& progress) {
    const std::vector<timing::Sensitivity> list = timing::sensitivity(
        material.machine, material.work(), [&progress](std::size_t done, std::size_t all) {
            progress.tell(fmt::format("sensitivity: {} of {} parameters", done, all));
        });
    const std::vector<std::string> names = material.names();
    output.text += "\n" + text_of(list, names);
    output.fields.push_back({"sensitivity", fields_of(list, names)});
    output.plots = plots_of(list);
    output.lines = fields_of(list, names);
}

void add_fit(Output& output, const Material& material, const Topology& modelled,
             const Progress& progress) {
    const std::vector<PaperCase> work = material.work();
    const timing::Fit fit = timing::fit(
        material.machine, timing::fitted_parameters(modelled), work,
        [&progress](int runs) { progress.tell(fmt::format("fit: {} runs of the model", runs)); });
    output.text += "\n" + text_of(fit, work, material.names());
    output.fields.push_back({"fit", fields_of(fit)});
}

std::string picture_list(const Material& material) {
    std::string text;
    for (const MeasuredCase& measured : material.cases) {
        if (!measured.picture.empty()) {
            text += (text.empty() ? "pictures, shaded with gradient=smooth:\n  " : "  ") +
                    measured.picture + "\n";
        }
    }
    return text;
}

Output paper_output(const Material& material, const ReportOptions& options,
                    const Topology& modelled, const std::string& drawn_by,
                    const Progress& progress) {
    const timing::Headset headset;
    std::vector<ReportRow> rows;
    std::vector<HeadsetLine> in_stereo;
    Output output;
    for (std::size_t i = 0; i < material.cases.size(); ++i) {
        progress.tell(fmt::format("model: {}", material.sources[i].name));
        rows.push_back(row_of(material.machine, material.sources[i], material.cases[i]));
        output.lines.push_back(fields_of(rows.back()));
        in_stereo.push_back({rows.back().name, timing::headset_time(material.machine, headset,
                                                                    material.cases[i].pair)});
        add_fields(in_stereo.back().time, output.lines.back());
    }
    output.text = table_of(rows) + text_of(Footnote{size_text(modelled), drawn_by}) +
                  text_of(in_stereo, headset) + picture_list(material);
    output.fields = {{"modelled", size_text(modelled)},
                     {"drawn_by", drawn_by},
                     {"rows", output.lines},
                     {"display", fields_of(headset)}};
    output.plots = plots_of(rows);
    if (options.sensitivity) {
        add_sensitivity(output, material, progress);
    }
    if (options.fit) {
        add_fit(output, material, modelled, progress);
    }
    return output;
}

Output cluster_output(const Material& material, const Topology& modelled,
                      const timing::Cluster& cluster, const Progress& progress) {
    const std::uint32_t nodes = nodes_per_computer(cluster);
    ClusterScaling scaling{cluster, nodes, nodes, {}};
    for (std::size_t i = 0; i < material.cases.size(); ++i) {
        progress.tell(fmt::format("model: {}", material.sources[i].name));
        scaling.rows.push_back(cluster_scaling_of(modelled, cluster, material.sources[i].name,
                                                  material.cases[i].work));
    }
    Output output{text_of(scaling), {}, fields_of(scaling), plots_of(scaling)};
    Fields parameters;
    for (const timing::ClusterRow& row : timing::cluster_rows()) {
        parameters.push_back({std::string(row.name), cluster.*row.value});
    }
    output.fields = {
        {"parameters", parameters}, {"points", output.lines}, {"ends", ends_of(scaling)}};
    return output;
}

Output scaling_output(const Material& material, const Progress& progress) {
    ScalingReport report{material.machine.gps, material.machine.renderers, {}};
    for (std::size_t i = 0; i < material.cases.size(); ++i) {
        progress.tell(fmt::format("model: {}", material.sources[i].name));
        report.rows.push_back(
            scaling_of(material.machine, material.sources[i].name, material.cases[i].work));
    }
    Output output{text_of(report), {}, fields_of(report), plots_of(report)};
    output.fields = {{"points", output.lines}};
    return output;
}

void write(const std::string& path, std::string_view text) {
    TextOutput file(path);
    file.put(text);
    file.finish();
}

void put(const Output& output, const ReportOptions& options) {
    try {
        TextOutput out("");
        out.put(options.json ? json_text(output.fields) + "\n" : output.text);
        out.finish();
    } catch (const OutputClosed&) {
        // The reader has gone. The files are still wanted.
    }
    if (!options.csv.empty()) {
        std::string csv = csv_heading(output.lines.at(0));
        for (const Fields& line : output.lines) {
            csv += csv_line(line);
        }
        write(options.csv, csv);
    }
    if (!options.picture.empty()) {
        constexpr std::size_t beside = 2;
        const bool is_wide = options.paper && !options.sensitivity;
        write_chart(options.picture, chart_of(output.plots, is_wide ? 1 : beside), "pxpl5 report");
    }
}

/// Makes the folder of the pictures before the work. Throws RequestError (failed) if they cannot be
/// written there.
void make_picture_folder(const std::string& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (!error && access(folder.c_str(), W_OK) != 0) {
        error = {errno, std::generic_category()};
    }
    if (error) {
        throw RequestError(ExitCode::failed, fmt::format("--pictures {}: cannot be written: {}",
                                                         folder, error.message()));
    }
}

}  // namespace

void check(const ReportOptions& options) {
    if (options.paper == options.scaling) {
        throw RequestError(ExitCode::usage, "report needs one of --paper and --scaling");
    }
    if (options.scaling && (options.sensitivity || options.fit || !options.pictures.empty())) {
        throw RequestError(ExitCode::usage,
                           "--sensitivity, --fit and --pictures go with --paper, not --scaling");
    }
    if (options.cluster && !options.scaling) {
        throw RequestError(ExitCode::usage, "--cluster goes with --scaling");
    }
    if (!options.cluster && !options.computers.is_empty()) {
        throw RequestError(ExitCode::usage,
                           "--link, --link-mbit, --cores and --cluster-set go with --cluster");
    }
    timing::cluster_of(options.computers);
    if (!options.picture.empty()) {
        check_picture_suffix("--picture", options.picture);
    }
    sources_of(options.data, options.rows);
    if (!options.pictures.empty()) {
        make_picture_folder(options.pictures);
    }
}

void run_report(Session& session, const ReportOptions& options, const Topology& modelled,
                const std::string& drawn_by) {
    Material material{sources_of(options.data, options.rows), {}, timing::machine_of(modelled)};
    std::optional<Progress> progress(std::in_place);
    MeasureOptions measuring{options.paper, options.paper, options.pictures, {}};
    measuring.progress = [&](std::size_t done, const Source& source) {
        const std::size_t rows = material.sources.size();
        progress->tell(fmt::format("{} {} of {}: {}", done < rows ? "row" : "picture",
                                   done % rows + 1, rows, source.name));
    };
    material.cases = measure(session, material.sources, measuring);
    const Output output =
        options.paper ? paper_output(material, options, modelled, drawn_by, *progress)
        : options.cluster
            ? cluster_output(material, modelled, timing::cluster_of(options.computers), *progress)
            : scaling_output(material, *progress);
    progress.reset();
    put(output, options);
}

}  // namespace pxpl5::host::report
