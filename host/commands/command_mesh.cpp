// Commands about surfaces as meshes: certificates, components, comparison.
#include <fmt/core.h>

#include <algorithm>
#include <iterator>

#include "host/base/chart_axis.hpp"
#include "host/base/error.hpp"
#include "host/base/part_file.hpp"
#include "host/commands/command_handlers.hpp"
#include "host/surface/compare.hpp"

namespace pxpl5::host {

namespace {

constexpr std::size_t listed_components = 10;

/// The filter of the options; nothing if no option is given.
std::optional<ComponentFilter> wished_filter(Session& session, const Arguments& arguments) {
    using Kind = ComponentFilter::Kind;
    if (arguments.options.size() > 1) {
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

Reply list_components(const MeshComponents& parts) {
    Reply reply{counted(parts.components.size(), "component"), {}};
    std::vector<Fields> list;
    for (std::size_t i = 0; i < std::min(listed_components, parts.components.size()); ++i) {
        const MeshComponent& part = parts.components[i];
        const std::string volume = part.volume_mm3
                                       ? fmt::format("{:.3f} ml", *part.volume_mm3 / 1000)
                                       : "no volume (holes)";
        reply.text += fmt::format(
            "\n{:>3}: {:>9} triangles, {:>10.2f} cm2, {}{}, center ({:.1f}, {:.1f}, {:.1f}) mm",
            i + 1, part.triangles, part.area_mm2 / 100, volume, part.closed ? "" : ", open",
            part.center_mm.x, part.center_mm.y, part.center_mm.z);
        Fields fields = {{"triangles", static_cast<std::int64_t>(part.triangles)},
                         {"area_mm2", part.area_mm2},
                         {"closed", part.closed},
                         {"center_mm", std::vector<double>{part.center_mm.x, part.center_mm.y,
                                                           part.center_mm.z}}};
        if (part.volume_mm3) {
            fields.push_back({"volume_ml", *part.volume_mm3 / 1000});
        }
        list.push_back(std::move(fields));
    }
    if (parts.components.size() > listed_components) {
        reply.text +=
            fmt::format("\nand {} smaller ones", parts.components.size() - listed_components);
    }
    reply.fields = {{"components", static_cast<std::int64_t>(parts.components.size())},
                    {"largest", list}};
    return reply;
}

/// Whether a word of `certificate` names a file instead of a surface.
bool is_mesh_file(const std::string& word) {
    const std::string suffix = suffix_of(word);
    return suffix == ".stl" || suffix == ".ply" || suffix == ".obj" || suffix == ".vtp" ||
           suffix == ".glb";
}

}  // namespace

Certificate file_certificate(const WeldedFile& file) {
    Certificate certificate = certify(file.mesh, patient_grid());
    certificate.collapsed = file.collapsed;
    return certificate;
}

Reply run_components(Session& session, const Arguments& arguments) {
    const std::string& name = arguments.words[0];
    const std::optional<ComponentFilter> filter = wished_filter(session, arguments);
    if (!filter) {
        return list_components(find_components(session.meshes.fetch(name), session.meshes.grid()));
    }
    const auto [all, drawn] = session.surfaces.set_components(name, *filter);
    return {fmt::format("{}: draws {} of {}", name, drawn, counted(all, "component")),
            {{"components", static_cast<std::int64_t>(all)},
             {"drawn", static_cast<std::int64_t>(drawn)}}};
}

namespace {

Reply certify_file(Session& session, const std::string& path) {
    Reply reply = certificate_reply(file_certificate(session.exports.read_mesh(path)), path);
    reply.fields.push_back({"of", "file"});
    return reply;
}

/// Certifies the whole surface, and warns where an export of the surface would be another mesh.
Reply certify_surface(Session& session, const std::string& name) {
    Reply reply =
        certificate_reply(certify(session.meshes.fetch(name, true), session.meshes.grid()), name);
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
