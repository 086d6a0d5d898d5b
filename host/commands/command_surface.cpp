// Commands about isosurfaces: what they are and how they look.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/nearest.hpp"
#include "host/commands/command_handlers.hpp"
#include "host/commands/text/tissues.hpp"
#include "host/phantom/phantom.hpp"

namespace pxpl5::host {

namespace {

/// The tissue's color if the name is one, else one that the surfaces before it do not have.
Color first_color(const std::string& name, std::size_t surfaces_before) {
    constexpr std::array others = {Color{236, 226, 200}, Color{120, 170, 220},
                                   Color{150, 200, 130}, Color{220, 150, 110},
                                   Color{190, 150, 210}, Color{225, 205, 110}};
    const Tissue* tissue = find_tissue(name);
    return tissue != nullptr ? tissue->color : others[surfaces_before % others.size()];
}

/// Settings of a new surface from its name: a built-in volume's suggestion, or a tissue of CT.
bool suggest(const Volume& volume, Surface& wish) {
    for (const PhantomSurface& suggested : suggested_surfaces(volume.name)) {
        if (suggested.name == wish.name) {
            wish.isovalue = suggested.isovalue;
            wish.color = {suggested.color_rgb[0], suggested.color_rgb[1], suggested.color_rgb[2]};
            return true;
        }
    }
    const Tissue* tissue = volume.modality == "CT" ? find_tissue(wish.name) : nullptr;
    if (tissue != nullptr) {
        wish.isovalue = tissue->isovalue_hu;
        wish.color = tissue->color;
    }
    return tissue != nullptr;
}

void take_preset(const std::string& name, const std::string& modality, Surface& wish) {
    const Tissue* tissue = find_tissue(name);
    if (tissue == nullptr) {
        std::vector<std::string_view> names;
        for (const Tissue& each : tissues()) {
            names.push_back(each.name);
        }
        refuse_command(fmt::format("preset: there is no '{}'{}", name, did_you_mean(name, names)));
    }
    if (const std::string refusal = refusal_of_tissue(name, modality); !refusal.empty()) {
        refuse_command(refusal);
    }
    wish.isovalue = tissue->isovalue_hu;
    wish.color = tissue->color;
}

void take_style(const Arguments& arguments, Surface& wish) {
    if (arguments.has("color")) {
        wish.color = parse_color(arguments.text("color", ""));
    }
    if (arguments.has("visible")) {
        wish.visible = arguments.text("visible", "") == "yes";
    }
    if (arguments.has("opacity")) {
        // A stipple mask has sixteenths; less than one would show nothing.
        const double share = arguments.number("opacity", 1);
        wish.opacity = std::max(1, static_cast<int>(std::lround(share * full_opacity)));
    }
    wish.rim = static_cast<int>(
        std::lround(arguments.number("rim", static_cast<double>(wish.rim) / max_rim) * max_rim));
}

/// The surface as it was, or as its name suggests, changed by the arguments.
Surface wished_surface(const Session& session, const std::optional<Surface>& known,
                       const Arguments& arguments) {
    const Volume& volume = session.volumes.volume();
    Surface wish = known.value_or(Surface{});
    wish.name = arguments.words[0];
    if (!known) {
        wish.color = first_color(wish.name, session.scene.surfaces.size());
    }
    if (wish.name.empty()) {
        refuse_command("a surface needs a name; it is empty");
    }
    bool has_isovalue = known.has_value() || suggest(volume, wish);
    if (arguments.has("preset")) {
        take_preset(arguments.text("preset", ""), volume.modality, wish);
        has_isovalue = true;
    }
    if (!has_isovalue && !arguments.has("iso")) {
        refuse_command(fmt::format(
            "surface {} is new: give its isovalue, iso=V with V in {} .. {}{}", wish.name,
            volume.minimum, volume.maximum,
            find_tissue(wish.name) != nullptr &&
                    refusal_of_tissue(wish.name, volume.modality).empty()
                ? fmt::format(", or preset={} if values are Hounsfield units", wish.name)
                : ""));
    }
    wish.isovalue = arguments.number("iso", wish.isovalue);
    if (arguments.has("table")) {
        wish.table = enum_named<CaseRule>(arguments.text("table", "")).value();
    }
    take_style(arguments, wish);
    return wish;
}

double share_of(int steps, int all) {
    return static_cast<double>(steps) / all;
}

/// The style of a surface as it is drawn, in sixteenths; empty if it is opaque and visible.
std::string style_text(const Surface& surface) {
    std::vector<std::string> differs;
    if (!surface.visible) {
        differs.emplace_back("not visible");
    }
    if (surface.opacity != full_opacity) {
        differs.push_back(fmt::format("opacity {}", share_of(surface.opacity, full_opacity)));
    }
    if (surface.rim != 0) {
        differs.push_back(fmt::format("rim {}", share_of(surface.rim, max_rim)));
    }
    return differs.empty() ? "" : fmt::format("; {}", fmt::join(differs, ", "));
}

}  // namespace

std::string left_out_text(const SurfaceReport& report) {
    return fmt::format(
        "{} of {} slabs do not fit into the memory of the GPs, which extract them again for each "
        "picture and mesh. {}",
        report.slabs_left_out, report.slabs.size(),
        report.gps_to_hold_all > 0
            ? fmt::format(
                  "About {} GPs, or more memory for each (gp.memory_mib), would hold them and the "
                  "other surfaces. The command scale adds GPs",
                  report.gps_to_hold_all)
            : "More memory for each GP (gp.memory_mib), or a part of the volume (crop=), helps");
}

Fields surface_fields(const Surface& surface, const SurfaceReport& report) {
    Fields fields = {{"name", surface.name},
                     {"isovalue", surface.isovalue},
                     {"table", enum_name(surface.table)},
                     {"visible", surface.visible},
                     {"opacity", share_of(surface.opacity, full_opacity)},
                     {"rim", share_of(surface.rim, max_rim)},
                     {"triangles", report.triangles},
                     {"vertices", report.vertices},
                     {"cells_active", report.cells_active},
                     {"cells_ambiguous", report.cells_ambiguous},
                     {"rows_skipped", report.rows_skipped},
                     {"area_mm2", report.area_mm2},
                     {"extraction_ms", report.elapsed_ms},
                     {"gp_memory_bytes", report.memory_bytes},
                     {"slabs_left_out", report.slabs_left_out},
                     {"gps_to_hold_all", report.gps_to_hold_all}};
    if (report.triangles > 0) {
        fields.push_back({"volume_ml", report.volume_mm3 / 1000});
    }
    return fields;
}

std::string surface_text(const Surface& surface, const SurfaceReport& report) {
    if (report.triangles == 0) {  // All voxels are on one side; the text does not name the side.
        return fmt::format("{}: isovalue {}, no triangles, extracted in {:.1f} ms{}", surface.name,
                           surface.isovalue, report.elapsed_ms, style_text(surface));
    }
    return fmt::format(
        "{}: isovalue {}, {} triangles, {} vertices, {:.1f} cm2, {:.1f} ml, extracted in {:.1f} "
        "ms{}{}",
        surface.name, surface.isovalue, report.triangles, report.vertices, report.area_mm2 / 100,
        report.volume_mm3 / 1000, report.elapsed_ms,
        report.slabs_left_out == 0 ? ""
                                   : fmt::format("; {} of {} slabs left out of memory",
                                                 report.slabs_left_out, report.slabs.size()),
        style_text(surface));
}

Reply run_surface(Session& session, const Arguments& arguments) {
    const std::string& name = arguments.words[0];
    const Volume& volume = session.volumes.volume();
    const std::optional<Surface> known = session.surfaces.find(name);
    const Surface wish = wished_surface(session, known, arguments);
    if (!known || arguments.has("iso") || arguments.has("preset") || arguments.has("table")) {
        session.surfaces.end_comparison(
            known && !known->compared_with.empty() ? known->compared_with : name);
        if (known) {
            session.surfaces.set_style(wish);  // Before a frame is requested with the surface.
        }
        try {
            session.surfaces.set(name, wish.isovalue, wish.table, wish.color);
        } catch (...) {
            if (session.surfaces.find(name) && known) {
                session.surfaces.set_style(*known);  // The command changes nothing.
            }
            throw;
        }
    }
    session.surfaces.set_style(wish);
    const SurfaceReport& report = session.surfaces.report_of(name);
    Reply reply{surface_text(wish, report), surface_fields(wish, report)};
    if (report.slabs_left_out > 0) {
        add_warning(reply, fmt::format("surface {}: {}", name, left_out_text(report)));
    }
    if (report.triangles == 0) {
        add_warning(reply, fmt::format("no surface there: the volume's values are {} .. {}",
                                       volume.minimum, volume.maximum));
    }
    return reply;
}

Reply run_remove(Session& session, const Arguments& arguments) {
    const std::optional<Surface> known = session.surfaces.find(arguments.words[0]);
    if (known && !known->compared_with.empty()) {
        session.surfaces.end_comparison(known->compared_with);
    } else {
        session.surfaces.end_comparison(arguments.words[0]);
        session.surfaces.remove(arguments.words[0]);
    }
    return {"removed " + arguments.words[0], {{"removed", arguments.words[0]}}};
}

Reply run_presets(Session&, const Arguments&) {
    Reply reply;
    std::vector<Fields> list;
    for (const Tissue& tissue : tissues()) {
        reply.text += fmt::format("{}{:<8} {:>8} HU  {}", reply.text.empty() ? "" : "\n",
                                  tissue.name, tissue.isovalue_hu, tissue.help);
        list.push_back({{"name", std::string(tissue.name)},
                        {"isovalue", tissue.isovalue_hu},
                        {"help", std::string(tissue.help)}});
    }
    reply.fields = {{"presets", list}};
    return reply;
}

}  // namespace pxpl5::host
