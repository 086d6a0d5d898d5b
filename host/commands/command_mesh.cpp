// Commands about surfaces as meshes: certificates, components, comparison.
#include <fmt/core.h>

#include <algorithm>
#include <iterator>

#include "host/base/chart_axis.hpp"
#include "host/base/error.hpp"
#include "host/base/part_file.hpp"
#include "host/commands/command_handlers.hpp"
#include "host/surface/compare.hpp"
#include "host/surface/parts/own_volume.hpp"

namespace pxpl5::host {

namespace {

constexpr std::size_t listed_components = 10;

/// The filter of the options that select components; nothing if no option does.
std::optional<ComponentFilter> selected_components(Session& session, const Arguments& arguments) {
    using Kind = ComponentFilter::Kind;
    if (arguments.options.size() - (arguments.has("cavities") ? 1 : 0) > 1) {
        refuse_command("components: give one of show=, min_mm2=, min_ml=, at=, at_mm=");
    }
    if (arguments.has("min_mm2")) {
        return ComponentFilter{Kind::at_least_mm2, arguments.number("min_mm2", 0), {}};
    }
    if (arguments.has("min_ml")) {
        return ComponentFilter{Kind::at_least_ml, arguments.number("min_ml", 0), {}};
    }
    if (arguments.has("at")) {
        const auto [x, y] = parse_pair("at", arguments.text("at", ""));
        const auto picked = session.frames.pick(x, y, shown_surface(session, arguments.words[0]));
        if (!picked) {
            refuse_command(
                fmt::format("at={},{}: no point of {} lies there", x, y, arguments.words[0]));
        }
        return ComponentFilter{Kind::at_point, 0, picked->pick.p_mm};
    }
    if (arguments.has("at_mm")) {
        const glm::dvec3 p_mm = parse_triple("at_mm", arguments.text("at_mm", ""), -1e6, 1e6);
        return ComponentFilter{Kind::at_point, 0, p_mm};
    }
    const std::string show = arguments.text("show", "");
    if (show == "all" || show == "largest") {
        return ComponentFilter{show == "all" ? Kind::all : Kind::largest, 0, {}};
    }
    return std::nullopt;
}

/// The filter of all options; nothing if no option is given.
std::optional<ComponentFilter> wished_filter(Session& session, const Arguments& arguments) {
    std::optional<ComponentFilter> filter = selected_components(session, arguments);
    if (!arguments.has("cavities")) {
        return filter;
    }
    const bool fills = arguments.text("cavities", "") == "no";
    if (!filter || (fills && filter->kind == ComponentFilter::Kind::all)) {
        refuse_command(
            "components: cavities= needs show=largest, min_mm2=, min_ml=, at= or at_mm=; "
            "min_mm2=0 cavities=no leaves out the cavities alone");
    }
    filter->fills_cavities = fills;
    return filter;
}

std::string volume_text(const MeshComponent& part) {
    if (!part.volume_mm3) {
        return "no volume (holes)";
    }
    const bool is_outside = !part.cavity && *part.volume_mm3 < 0;
    return fmt::format("{:.3f} ml{}", *part.volume_mm3 / 1000,
                       part.closed  ? ""
                       : is_outside ? " (of the outside, closed by the faces of the scan)"
                                    : " (closed by the faces of the scan)");
}

/// Returns ", open", ", cavity" or ", open cavity of 3"; numbers count from 1.
std::string kind_text(const MeshComponent& part) {
    std::string text = part.closed ? "" : " open";
    if (part.cavity) {
        text += " cavity";
    }
    if (part.cavity_of) {
        text += fmt::format(" of {}", *part.cavity_of + 1);
    }
    return text.empty() ? "" : "," + text;
}

Fields component_fields(const MeshComponent& part, bool is_drawn) {
    Fields fields = {
        {"triangles", static_cast<std::int64_t>(part.triangles)},
        {"area_mm2", part.area_mm2},
        {"closed", part.closed},
        {"closed_but_for_border", part.closed_but_for_border},
        {"cavity", part.cavity},
        {"drawn", is_drawn},
        {"center_mm", std::vector<double>{part.center_mm.x, part.center_mm.y, part.center_mm.z}}};
    if (part.cavity_of) {
        fields.push_back({"cavity_of", static_cast<std::int64_t>(*part.cavity_of) + 1});
    }
    if (part.volume_mm3) {
        fields.push_back({"volume_ml", *part.volume_mm3 / 1000});
    }
    return fields;
}

/// Counts of a surface's components.
struct DrawnCounts {
    std::int64_t all = 0, cavities = 0, drawn = 0, drawn_cavities = 0;
    /// Cavities that are not drawn although the components around them are.
    std::int64_t filled = 0;
    double filled_ml = 0;
    std::optional<double> drawn_ml;  ///< See DrawnComponents::volume_ml().
};

DrawnCounts counts_of(const DrawnComponents& components) {
    DrawnCounts counts;
    counts.drawn_ml = components.volume_ml(OpenParts::without_volume);
    const std::vector<MeshComponent>& list = components.parts.components;
    for (const MeshComponent& part : list) {
        const bool is_drawn = components.is_drawn(part);
        ++counts.all;
        counts.cavities += part.cavity ? 1 : 0;
        counts.drawn += is_drawn ? 1 : 0;
        counts.drawn_cavities += is_drawn && part.cavity ? 1 : 0;
        if (!is_drawn && part.cavity_of && components.is_drawn(list[*part.cavity_of])) {
            ++counts.filled;
            counts.filled_ml -= *part.volume_mm3 / 1000;
        }
    }
    return counts;
}

std::string counted_cavities(std::int64_t cavities) {
    return cavities == 1 ? "1 cavity" : fmt::format("{} cavities", cavities);
}

std::string cavities_text(std::int64_t cavities) {
    return cavities == 0
               ? ""
               : fmt::format(", {} of them {}", cavities, cavities == 1 ? "a cavity" : "cavities");
}

Fields count_fields(const DrawnCounts& counts, const ComponentFilter& filter) {
    Fields fields = {{"components", counts.all},
                     {"cavities", counts.cavities},
                     {"filter", filter_text(filter)},
                     {"drawn", counts.drawn},
                     {"drawn_cavities", counts.drawn_cavities},
                     {"filled_cavities", counts.filled},
                     {"filled_ml", counts.filled_ml}};
    if (counts.drawn_ml) {
        fields.push_back({"drawn_ml", *counts.drawn_ml});
    }
    return fields;
}

/// States what is drawn of the components, and which cavities are filled by that.
std::string drawn_text(const DrawnCounts& counts) {
    std::string text = fmt::format("draws {} of {}{}", counts.drawn,
                                   counted(static_cast<std::uint64_t>(counts.all), "component"),
                                   cavities_text(counts.drawn_cavities));
    if (counts.drawn_ml) {
        text += fmt::format("; {:.3f} ml", *counts.drawn_ml);
    }
    if (counts.filled > 0) {
        text += fmt::format("; {} of {:.3f} ml {} filled", counted_cavities(counts.filled),
                            counts.filled_ml, counts.filled == 1 ? "is" : "are");
    }
    return text;
}

Reply list_components(const DrawnComponents& components, const ComponentFilter& filter) {
    const std::vector<MeshComponent>& parts = components.parts.components;
    const DrawnCounts counts = counts_of(components);
    const bool draws_all = filter.kind == ComponentFilter::Kind::all;
    Reply reply{counted(parts.size(), "component") + cavities_text(counts.cavities), {}};
    std::vector<Fields> list;
    for (std::size_t i = 0; i < std::min(listed_components, parts.size()); ++i) {
        const MeshComponent& part = parts[i];
        const bool is_drawn = components.is_drawn(part);
        reply.text += fmt::format(
            "\n{:>3}: {:>9} triangles, {:>10.2f} cm2, {}{}{}, center ({:.1f}, {:.1f}, {:.1f}) mm",
            i + 1, part.triangles, part.area_mm2 / 100, volume_text(part), kind_text(part),
            draws_all  ? ""
            : is_drawn ? ", drawn"
                       : ", not drawn",
            part.center_mm.x, part.center_mm.y, part.center_mm.z);
        list.push_back(component_fields(part, is_drawn));
    }
    if (parts.size() > listed_components) {
        reply.text += fmt::format("\nand {} smaller ones", parts.size() - listed_components);
    }
    if (!draws_all) {
        reply.text += fmt::format("\n{}: {}", filter_text(filter), drawn_text(counts));
    }
    reply.fields = count_fields(counts, filter);
    reply.fields.push_back({"largest", list});
    return reply;
}

/// Whether a word of `certificate` names a file instead of a surface.
bool is_mesh_file(const std::string& word) {
    const std::string suffix = suffix_of(word);
    return suffix == ".stl" || suffix == ".ply" || suffix == ".obj" || suffix == ".vtp" ||
           suffix == ".glb";
}

}  // namespace

Certificate file_certificate(const WeldedFile& file, const Pause& pause) {
    Certificate certificate = certify(file.mesh, patient_grid(), pause);
    certificate.collapsed = file.collapsed;
    return certificate;
}

Reply run_components(Session& session, const Arguments& arguments) {
    const std::string& name = arguments.words[0];
    const std::optional<ComponentFilter> filter = wished_filter(session, arguments);
    const Surface& surface = session.meshes.surface(name);
    if (!filter) {
        return list_components(session.meshes.components(surface), surface.components);
    }
    const DrawnCounts counts = counts_of(session.surfaces.set_components(name, *filter));
    return {name + ": " + drawn_text(counts), count_fields(counts, *filter)};
}

void add_part(Session& session, const std::string& surface, glm::dvec3 p_mm, Reply& reply) {
    const ChosenComponent chosen =
        session.meshes.component_at(session.meshes.surface(surface), p_mm);
    const std::vector<MeshComponent>& all = chosen.parts.components;
    const auto [number, volume_mm3] = own_volume(chosen.parts, chosen.number);
    const MeshComponent& part = all[number];
    const std::int64_t cavities = std::ranges::count_if(
        all, [number = number](const MeshComponent& other) { return other.cavity_of == number; });
    Fields fields = {{"number", static_cast<std::int64_t>(number) + 1},
                     {"of", static_cast<std::int64_t>(all.size())},
                     {"cavity", part.cavity},
                     {"cavities", cavities},
                     {"closed", part.closed},
                     {"area_mm2", part.area_mm2}};
    if (volume_mm3) {
        fields.push_back({"volume_ml", *volume_mm3 / 1000});
    }
    // Small ones have digits, too.
    const auto with_digits = [](double value) {
        return value < 1 ? fmt::format("{:.3g}", value) : fmt::format("{:.3f}", value);
    };
    reply.text +=
        fmt::format("\n{} {} of {}: {}{}{}, {} cm2",
                    part.cavity ? "cavity, component" : "component", number + 1, all.size(),
                    volume_mm3 ? with_digits(*volume_mm3 / 1000) + " ml"
                               : "no volume, because it or a component in it has holes",
                    volume_mm3 && cavities > 0 ? " without " + counted_cavities(cavities) : "",
                    volume_mm3 && !part.closed ? " (closed by the faces of the scan)" : "",
                    with_digits(part.area_mm2 / 100));
    reply.fields.push_back({"part", fields});
}

namespace {

Reply certify_file(Session& session, const std::string& path) {
    const Pause pause = [&] { session.conversation.pause(path); };
    Reply reply = certificate_reply(file_certificate(session.exports.read_mesh(path), pause), path);
    reply.fields.push_back({"of", "file"});
    return reply;
}

/// Certifies the whole surface, and warns where an export of the surface would be another mesh.
Reply certify_surface(Session& session, const std::string& name) {
    const Pause pause = session.meshes.pause_of(session.meshes.surface(name));
    Reply reply = certificate_reply(
        certify(session.meshes.fetch(name, true), session.meshes.grid(), pause), name);
    const ComponentFilter& filter = session.meshes.surface(name).components;
    const std::vector<std::string> clips = clip_words(session.scene);
    reply.fields.push_back({"of", "whole surface"});
    reply.fields.push_back({"drawn_components", filter_text(filter)});
    reply.fields.push_back({"clips", clips});
    if (filter.kind != ComponentFilter::Kind::all) {
        add_warning(reply, "of the whole surface; not all of its components are drawn", "\n  ");
    }
    if (!clips.empty()) {
        add_warning(reply,
                    fmt::format("of the whole surface; `export` cuts the mesh by {}",
                                counted(clips.size(), "clip plane")),
                    "\n  ");
    }
    return reply;
}

}  // namespace

Reply run_certificate(Session& session, const Arguments& arguments) {
    std::vector<std::string> names = arguments.words;
    for (const Surface& surface : session.scene.surfaces) {
        if (arguments.words.empty() && surface.compared_with.empty()) {
            names.push_back(surface.name);
        }
    }
    if (names.empty()) {
        refuse_command("certificate: there is no surface yet");
    }
    Reply reply;
    std::vector<Fields> list;
    for (const std::string& name : names) {
        const Reply one =
            is_mesh_file(name) ? certify_file(session, name) : certify_surface(session, name);
        reply.text += (reply.text.empty() ? "" : "\n") + one.text;
        list.push_back(one.fields);
        std::ranges::copy(one.warnings, std::back_inserter(reply.warnings));
    }
    reply.fields = {{"certificates", list}};
    return reply;
}

Reply run_compare(Session& session, const Arguments& arguments) {
    const std::string& name = arguments.words[0];
    session.surfaces.report_of(name);  // Throws if there is no such surface.
    if (arguments.words.size() > 1) {
        if (!session.surfaces.end_comparison(name)) {
            refuse_command(fmt::format("compare: {} is not compared", name));
        }
        return {name + " is drawn again", {{"name", name}}};
    }
    const MeshComparison comparison = session.surfaces.compare(name);
    Reply reply = comparison_reply(comparison, name + ":watertight", name + ":lorensen1987");
    reply.text += fmt::format("\nonly these cells of {0} are drawn until 'compare {0} off'", name);
    return reply;
}

}  // namespace pxpl5::host
