// The command `export`: surfaces as a mesh file, with the certificate of that file beside it.
#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>

#include "host/base/chart_axis.hpp"
#include "host/base/digest.hpp"
#include "host/base/error.hpp"
#include "host/base/part_file.hpp"
#include "host/commands/command_handlers.hpp"
#include "host/commands/text/picture_text.hpp"
#include "host/commands/text/volume_text.hpp"
#include "host/session/transfer/detail.hpp"

namespace pxpl5::host {

namespace {

std::vector<double> triple_of(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

/// The layout as `load raw=` takes it; empty for a file with a header.
std::string raw_text(const ImportOptions& options) {
    if (options.raw == nullptr) {
        return "";
    }
    const bus::schema::RawLayoutT& raw = *options.raw;
    return fmt::format("{}x{}x{},{}{},{}", raw.nx, raw.ny, raw.nz, raw.type,
                       raw.big_endian ? ",be" : "", raw.offset);
}

/// Which volume it is, and how it was read.
Fields volume_identity(const Session& session) {
    const Volume& volume = session.volumes.volume();
    const ImportOptions& options = session.volumes.options();
    const glm::dmat4& m = volume.voxel_to_patient;
    std::vector<std::string> findings;
    for (const Finding& finding : volume.findings) {
        findings.push_back(finding_name(finding.kind) + ": " + finding.text);
    }
    const auto counts = [](const std::vector<std::uint32_t>& list) {
        return std::vector<std::int64_t>(list.begin(), list.end());
    };
    return {{"file", volume.source},
            {"series", volume.series},
            {"modality", volume.modality},
            {"digest", fmt::format("fnv1a:{:016x}", volume.digest)},
            {"dims", std::vector<std::int64_t>{volume.nx, volume.ny, volume.nz}},
            {"type", std::string(enum_name(volume.type))},
            {"spacing_mm", triple_of(spacing_mm(volume))},
            {"origin_mm", triple_of(glm::dvec3(m[3]))},
            {"x_mm", triple_of(glm::dvec3(m[0]))},
            {"y_mm", triple_of(glm::dvec3(m[1]))},
            {"z_mm", triple_of(glm::dvec3(m[2]))},
            {"read_as", Fields{{"series", options.series},
                               {"frame", std::int64_t{options.frame}},
                               {"raw", raw_text(options)},
                               {"spacing_mm", options.spacing_mm},
                               {"orientation", options.orientation},
                               {"origin_mm", options.origin_mm},
                               {"crop_first", counts(options.crop_first)},
                               {"crop_size", counts(options.crop_size)},
                               {"resample_size", counts(options.resample_size)},
                               {"resample_mm", options.resample_spacing_mm},
                               {"smooth_mm", options.smooth_mm},
                               {"gradient", std::string(enum_name(options.gradient))}}},
            {"findings", findings}};
}

}  // namespace

std::string filter_text(const ComponentFilter& filter) {
    using Kind = ComponentFilter::Kind;
    const std::string_view end = filter.fills_cavities ? " cavities=no" : "";
    switch (filter.kind) {
        case Kind::largest:
            return fmt::format("largest{}", end);
        case Kind::at_least_mm2:
            return fmt::format("min_mm2={}{}", filter.least, end);
        case Kind::at_least_ml:
            return fmt::format("min_ml={}{}", filter.least, end);
        case Kind::at_point:
            return fmt::format("at {}, {}, {} mm{}", filter.p_mm.x, filter.p_mm.y, filter.p_mm.z,
                               end);
        case Kind::all:
            break;
    }
    return "all";
}

std::vector<std::string> clip_words(const Scene& scene) {
    std::vector<std::string> words;
    for (const SceneClip& clip : scene.clips) {
        words.push_back(clip.words);
    }
    return words;
}

namespace {

/// How smoothing has changed a surface.
Fields smoothing_fields(const Smoothing& smoothing) {
    return {{"farthest_mm", smoothing.farthest_mm},
            {"mean_mm", smoothing.mean_mm},
            {"volume_change_ml", smoothing.volume_mm3 / 1000}};
}

Fields surface_parameters(const Surface& surface, const FileSurface& file, Fields certificate) {
    Fields fields = {{"name", surface.name},
                     {"isovalue", surface.isovalue},
                     {"table", std::string(enum_name(surface.table))},
                     {"components", filter_text(surface.components)}};
    if (file.moved_mm) {
        fields.push_back({"moved_mm", *file.moved_mm});
        fields.push_back({"components_before", file.components_before});
    }
    if (file.within_mm) {
        fields.push_back({"within_mm", *file.within_mm});
    }
    if (file.smoothing) {
        fields.push_back({"smoothing", smoothing_fields(*file.smoothing)});
    }
    fields.push_back({"certificate", std::move(certificate)});
    return fields;
}

/// Size and digest of the file, which tie a certificate to it. Throws RequestError.
Fields file_identity(const std::string& path) {
    std::ifstream stream(path, std::ios::binary);
    Digest digest;
    std::int64_t bytes = 0;
    std::vector<char> block(std::size_t{1} << 20);
    while (stream.read(block.data(), static_cast<std::streamsize>(block.size())) ||
           stream.gcount() > 0) {
        const auto count = static_cast<std::size_t>(stream.gcount());
        digest.add(std::as_bytes(std::span(block.data(), count)));
        bytes += stream.gcount();
    }
    if (bytes == 0) {
        throw RequestError(ExitCode::failed,
                           path + ": was written, but cannot be read again for its certificate");
    }
    return {{"mesh_bytes", bytes}, {"mesh_digest", fmt::format("fnv1a:{:016x}", digest.value())}};
}

void write_text(const std::string& path, const std::string& text) {
    remove_abandoned_parts(path);
    PartFile file(path);
    file.write(text);
    if (const std::string failure = file.keep(); !failure.empty()) {
        throw RequestError(ExitCode::failed,
                           fmt::format("{}: cannot be written: {}", path, failure));
    }
}

void add_warnings(Reply& reply, const Session& session, const MeshExportReport& report) {
    for (const char* words : {"; decimated from", "; not decimated"}) {
        if (const std::size_t at = report.text.find(words); at != std::string::npos) {
            reply.warnings.push_back(report.text.substr(at + 2));  // The writer's text has it.
        }
    }
    if (is_assumed(session.volumes.volume())) {
        add_warning(reply,
                    "place or spacing of the volume is assumed, so the mesh's is too: see info");
    }
}

/// Returns "; " and what closes an open mesh of the surface.
std::string open_remedy(const Surface& surface, const MeshExport& wish) {
    std::string remedy;
    if (!wish.cap && wish.detail == 0) {
        remedy = "; cap=yes closes a mesh at the scan's border and at clip planes";
    }
    if (surface.table == CaseRule::lorensen1987) {
        remedy += fmt::format("; table={} leaves no holes", enum_name(CaseRule::watertight));
    }
    return remedy;
}

/// The facts of a surface in the file that a batch decides by.
Fields file_facts(const FileSurface& surface, const Certificate& certificate) {
    Fields fields = {{"name", surface.name},
                     {"triangles", certificate.triangles},
                     {"vertices", surface.vertices},
                     {"closed", certificate.closed()},
                     {"watertight", certificate.watertight()},
                     {"manifold", certificate.manifold()},
                     {"oriented", certificate.oriented()},
                     {"inside_out", certificate.is_inside_out()},
                     {"holes", certificate.holes},
                     {"open_edges", certificate.count(DefectKind::open_edge)},
                     {"components", certificate.components}};
    if (surface.moved_mm) {
        fields.push_back({"components_before", surface.components_before});
        fields.push_back({"moved_mm", *surface.moved_mm});
    }
    if (surface.within_mm) {
        fields.push_back({"within_mm", *surface.within_mm});
    }
    if (surface.smoothing) {
        fields.push_back({"smoothing", smoothing_fields(*surface.smoothing)});
    }
    return fields;
}

/// Adds a line about a surface in the file: a warning if it is open, or no solid for another
/// reason, or has fewer components than before its decimation.
void add_file_surface(Reply& reply, const FileSurface& surface, const Certificate& certificate,
                      const std::string& verdict, const std::string& remedy) {
    const std::int64_t lost = surface.components_before - certificate.components;
    std::string line = verdict;
    if (lost > 0) {
        line += fmt::format("; decimation dropped {} of {} components", lost,
                            surface.components_before);
    } else if (surface.moved_mm) {
        line +=
            fmt::format("; {} before and after the decimation",
                        counted(static_cast<std::uint64_t>(certificate.components), "component"));
    }
    if (surface.smoothing) {
        line += fmt::format(
            "; smoothed: vertices moved by {} mm or less, {:.3f} mm on average, and "
            "the volume changed by {:+.3f} ml",
            bound_text(surface.smoothing->farthest_mm), surface.smoothing->mean_mm,
            surface.smoothing->volume_mm3 / 1000);
    }
    if (!certificate.closed()) {
        line += remedy;
    }
    if (surface.within_mm) {
        line += fmt::format(
            "; {}simplified: no point is farther than {} mm from the exact "
            "surface, and parts of the surface that lie in one cell are gone",
            certificate.watertight() ? "watertight, " : "", bound_text(*surface.within_mm));
    }
    const bool is_solid =
        certificate.closed() && certificate.good() && !certificate.is_inside_out();
    if (is_solid && lost <= 0) {
        reply.text += "\n" + line;
    } else {
        add_warning(reply, line);
    }
}

std::string certificate_file_of(const std::string& mesh) {
    return mesh + ".certificate.json";
}

}  // namespace

std::vector<std::string> files_beside_mesh(const std::string& mesh) {
    std::vector<std::string> files = {certificate_file_of(mesh)};
    if (const std::filesystem::path colors = color_file_of(mesh); !colors.empty()) {
        files.push_back(colors.string());
    }
    return files;
}

Reply run_export(Session& session, const Arguments& arguments) {
    const std::string& path = arguments.words[0];
    MeshExport wish;
    wish.error_mm = arguments.number("error", 0);
    wish.keep = arguments.number("keep", wish.error_mm > 0 ? 0 : 1);
    wish.cap = arguments.text("cap", "no") == "yes";
    wish.detail = parse_whole("detail", arguments.text("detail", "0"), 0, max_detail);
    wish.smoothing = parse_whole("smoothing", arguments.text("smoothing", "0"));
    const std::string_view other = wish.cap             ? "cap=yes"
                                   : wish.error_mm > 0  ? "error="
                                   : wish.keep < 1      ? "keep="
                                   : wish.smoothing > 0 ? "smoothing="
                                                        : "";
    if (wish.detail > 0 && !other.empty()) {
        refuse_command(
            fmt::format("export: detail={} and {} cannot be combined, because {} starts from the "
                        "exact surface; leave one out",
                        wish.detail, other, other.substr(0, other.find('='))));
    }
    const std::string axes = arguments.text("axes", "LPS");
    wish.ras = axes == "RAS";
    for (std::string left = arguments.text("surfaces", ""); !left.empty();) {
        const std::size_t comma = std::min(left.find(','), left.size());
        wish.surfaces.push_back(left.substr(0, comma));
        left.erase(0, comma + 1);
    }
    wish.description = picture_extras(session, session.scene.camera).description;
    const MeshExportReport report = session.exports.mesh(path, wish);
    const std::string beside = certificate_file_of(path);
    Reply reply{fmt::format("wrote {}: {}", path, report.text), {}};
    std::int64_t vertices = 0, holes = 0, open_edges = 0;
    std::vector<Fields> surfaces, facts;
    for (const FileSurface& surface : report.surfaces) {
        const Certificate certificate = file_certificate(surface.file);
        const Surface& drawn = session.meshes.surface(surface.name);
        const Reply one = certificate_reply(certificate, surface.name);
        add_file_surface(reply, surface, certificate, one.text.substr(0, one.text.find('\n')),
                         open_remedy(drawn, wish));
        vertices += surface.vertices;
        holes += certificate.holes;
        open_edges += certificate.count(DefectKind::open_edge);
        facts.push_back(file_facts(surface, certificate));
        surfaces.push_back(surface_parameters(drawn, surface, one.fields));
    }
    reply.fields = {{"file", path},   {"triangles", report.triangles}, {"vertices", vertices},
                    {"axes", axes},   {"certificate", beside},         {"closed", open_edges == 0},
                    {"holes", holes}, {"open_edges", open_edges},      {"surfaces", facts}};
    Fields file = {{"schema", json_schema},
                   {"file", std::filesystem::path(path).filename().string()}};
    std::ranges::move(file_identity(path), std::back_inserter(file));
    std::ranges::move(Fields{{"axes", axes},
                             {"unit", "mm"},
                             {"text", report.text},
                             {"keep", wish.keep},
                             {"error_mm", wish.error_mm},
                             {"smoothing", std::int64_t{wish.smoothing}},
                             {"cap", wish.cap},
                             {"detail", std::int64_t{wish.detail}},
                             {"clips", clip_words(session.scene)},
                             {"volume", volume_identity(session)},
                             {"surfaces", surfaces}},
                      std::back_inserter(file));
    write_text(beside, json_text(file) + "\n");
    for (const std::string& name : report.empty) {
        add_warning(reply, name + " has no triangles and is not in the file");
    }
    add_warnings(reply, session, report);
    return reply;
}

}  // namespace pxpl5::host
