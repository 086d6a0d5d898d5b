// Commands about volumes: load, info and the isovalue atlas.
#include <fmt/core.h>

#include "host/base/error.hpp"
#include "host/commands/command_handlers.hpp"
#include "host/commands/load_options.hpp"
#include "host/commands/pictures/chart_file.hpp"
#include "host/commands/text/picture_text.hpp"
#include "host/commands/text/progress_bar.hpp"
#include "host/commands/text/volume_text.hpp"
#include "host/surface/atlas/atlas_chart.hpp"
#include "host/surface/atlas/histogram.hpp"
#include "host/surface/atlas/isovalue_components.hpp"
#include "host/surface/atlas/plateaus.hpp"
#include "host/volume/identity.hpp"
#include "host/volume/reduced.hpp"

namespace pxpl5::host {

namespace {

constexpr int atlas_bins = 256;
constexpr const char* usual_steps = "256";

Reply describe_loaded(const Session& session, VolumeDetail detail) {
    const ArchiveFacts* archive = session.volumes.archive();
    return archive != nullptr ? describe_archive(*archive)
                              : describe_volume(session.volumes.volume(), detail);
}

/// Throws RequestError (bad_data) if the option `name` states another digest of `part`.
void check_digest(const Volume& volume, const Arguments& arguments, const std::string& name,
                  std::string_view part, std::uint64_t value) {
    const std::string digest = fmt::format("{:016x}", value);
    const std::string wanted = arguments.text(name, digest);
    if (digest != wanted) {
        throw RequestError(ExitCode::bad_data,
                           fmt::format("{} is not the volume that was wanted: the digest of its "
                                       "{} is {}, not {}",
                                       volume.source, part, digest, wanted));
    }
}

/// Throws RequestError (bad_data) if the options name another volume.
void check_identity(const Volume& volume, const Arguments& arguments) {
    check_digest(volume, arguments, "digest", "voxels", volume.digest);
    check_digest(volume, arguments, "place", "size and place", place_digest(volume));
}

/// `count` isovalues evenly between the volume's least and greatest value, neither of them.
std::vector<double> even_isovalues(double low, double high, int count) {
    std::vector<double> isovalues;
    for (int i = 1; i <= count; ++i) {
        isovalues.push_back(low + (high - low) * i / (count + 1));
    }
    return isovalues;
}

AtlasContent atlas_content(const Volume& volume, const std::vector<AtlasRow>& rows) {
    AtlasContent content;
    content.title = volume.name + ", watertight";
    content.value_unit = volume.modality == "CT" ? "HU" : "";
    content.rows = rows;
    content.plateaus = find_plateaus(rows);
    const Histogram counted = histogram(volume, atlas_bins);
    content.histogram = {counted.first,
                         counted.first + counted.width * static_cast<double>(counted.counts.size()),
                         counted.counts};
    return content;
}

Fields atlas_fields(const std::vector<AtlasRow>& rows) {
    std::vector<Fields> list;
    for (const AtlasRow& row : rows) {
        list.push_back({{"isovalue", row.isovalue},
                        {"triangles", static_cast<std::int64_t>(row.triangles)},
                        {"area_mm2", row.area_mm2},
                        {"volume_ml", row.volume_mm3 / 1000},
                        {"components", static_cast<std::int64_t>(row.components)}});
    }
    std::vector<Fields> plateaus;
    for (const AtlasPlateau& plateau : find_plateaus(rows)) {
        plateaus.push_back({{"from", plateau.from}, {"to", plateau.to}});
    }
    return {{"rows", list}, {"plateaus", plateaus}};
}

}  // namespace

Reply run_load(Session& session, const Arguments& arguments) {
    struct ForgetSeries {
        TimeSeries& series;
        ~ForgetSeries() { series.forget_others(); }
    };
    const ForgetSeries forget{session.series};
    const LoadReport report = [&] {
        const ProgressBar bar(session);
        return session.volumes.load(arguments.words[0], load_options(arguments));
    }();
    Reply reply = describe_loaded(session, VolumeDetail::brief);
    reply.text += fmt::format(
        "\nread in {:.0f} ms, distributed in {:.0f} ms; {:.1f} MiB on the GPs", report.read_ms,
        report.distribute_ms, static_cast<double>(report.memory_bytes) / (1 << 20));
    reply.fields.push_back({"read_ms", report.read_ms});
    reply.fields.push_back({"distribute_ms", report.distribute_ms});
    reply.fields.push_back({"gp_memory_bytes", report.memory_bytes});
    return reply;
}

Reply run_info(Session& session, const Arguments& arguments) {
    if (arguments.words.empty()) {
        if (session.volumes.has_volume()) {
            check_identity(session.volumes.volume(), arguments);
        }
        return describe_loaded(session, VolumeDetail::all);
    }
    const std::string& source = arguments.words[0];
    if (is_archive(source)) {
        return describe_archive(session.volumes.read_archive(source));
    }
    const Volume volume = session.volumes.read(source, load_options(arguments));
    check_identity(volume, arguments);
    return describe_volume(volume);
}

Reply run_atlas(Session& session, const Arguments& arguments) {
    const Volume& volume = session.volumes.volume();
    require_all_voxels(volume, "atlas, which counts components,");
    const double low = arguments.number("from", volume.minimum);
    const double high = arguments.number("to", volume.maximum);
    const int steps = parse_whole("steps", arguments.text("steps", usual_steps));
    if (!(low < high)) {
        refuse_command(fmt::format("atlas: from={} is not below to={}", low, high));
    }
    const std::vector<double> isovalues = even_isovalues(low, high, steps);
    std::vector<AtlasRow> rows = session.meshes.measure(isovalues, CaseRule::watertight);
    const std::vector<ComponentCounts> components = count_components(volume, isovalues);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        rows[i].components = rows[i].triangles == 0 ? 0 : components[i].surface();
    }
    const AtlasContent content = atlas_content(volume, rows);
    Reply reply{atlas_text(content), atlas_fields(rows)};
    if (!arguments.words.empty()) {
        const AtlasChart chart = atlas_chart(content);
        write_chart_file(
            session,
            {chart.size, chart.background, chart.marks, "isovalue atlas of " + content.title},
            arguments.words[0]);
        reply.text += "\nwrote " + arguments.words[0];
        reply.fields.push_back({"file", arguments.words[0]});
    }
    return reply;
}

}  // namespace pxpl5::host
