#include "host/command_handlers.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/commands.hpp"
#include "host/error.hpp"
#include "host/nearest.hpp"
#include "host/phantom/phantom.hpp"
#include "host/picture_text.hpp"

namespace pxpl5::host {

namespace {

constexpr double max_isovalue = std::numeric_limits<float>::max();
constexpr double max_angle_deg = 36000;
constexpr double min_zoom = 0.05, max_zoom = 100;
constexpr int max_orbit_frames = 100'000;

[[noreturn]] void refuse(const std::string& text) {
    throw RequestError(ExitCode::usage, text);
}

CaseTable parse_table(const std::string& text) {
    for (std::size_t i = 0; i < case_table_names.size(); ++i) {
        if (case_table_names[i] == text) {
            return static_cast<CaseTable>(i);
        }
    }
    refuse(fmt::format("table: there is no '{}'{}", text, did_you_mean(text, case_table_names)));
}

Fields surface_fields(const Surface& surface, const SurfaceReport& report) {
    return {{"name", surface.name},
            {"isovalue", surface.isovalue},
            {"table", std::string(case_table_names[static_cast<std::size_t>(surface.table)])},
            {"triangles", report.triangles},
            {"vertices", report.vertices},
            {"cells_active", report.cells_active},
            {"cells_ambiguous", report.cells_ambiguous},
            {"rows_skipped", report.rows_skipped},
            {"area_mm2", report.area_mm2},
            {"volume_ml", report.volume_mm3 / 1000},
            {"extraction_ms", report.elapsed_ms},
            {"gp_memory_bytes", report.memory_bytes}};
}

std::string surface_text(const Surface& surface, const SurfaceReport& report) {
    return fmt::format(
        "{}: isovalue {}, {} triangles, {} vertices, {:.1f} cm2, {:.1f} ml, extracted in {:.1f} ms",
        surface.name, surface.isovalue, report.triangles, report.vertices, report.area_mm2 / 100,
        report.volume_mm3 / 1000, report.elapsed_ms);
}

/// The surface as it was, or as a built-in volume suggests, changed by the arguments.
Surface wished_surface(const Volume& volume, const std::optional<Surface>& known,
                       const Arguments& arguments) {
    Surface wish = known.value_or(Surface{});
    wish.name = arguments.words[0];
    if (wish.name.empty()) {
        refuse("a surface needs a name; it is empty");
    }
    bool has_isovalue = known.has_value();
    for (const PhantomSurface& suggested : suggested_surfaces(volume.name)) {
        if (!known && suggested.name == wish.name) {
            wish.isovalue = suggested.isovalue;
            wish.colour = {suggested.colour_rgb[0], suggested.colour_rgb[1],
                           suggested.colour_rgb[2]};
            has_isovalue = true;
        }
    }
    if (!has_isovalue && !arguments.has("iso")) {
        refuse(fmt::format("surface {} is new: give its isovalue, iso=V with V in {} .. {}",
                           wish.name, volume.minimum, volume.maximum));
    }
    wish.isovalue = arguments.number("iso", wish.isovalue, -max_isovalue, max_isovalue);
    if (arguments.has("table")) {
        wish.table = parse_table(arguments.text("table", ""));
    }
    if (arguments.has("color")) {
        wish.colour = parse_colour(arguments.text("color", ""));
    }
    return wish;
}

Reply describe_loaded(const Session& session) {
    const phigs::Content* archive = session.archive();
    return archive != nullptr ? describe_archive(*archive) : describe_volume(session.volume());
}

}  // namespace

Reply run_load(Session& session, const Arguments& arguments) {
    const LoadReport report = session.load(arguments.words[0]);
    Reply reply = describe_loaded(session);
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
        return describe_loaded(session);
    }
    const std::string& source = arguments.words[0];
    return phigs::is_archive(source) ? describe_archive(phigs::flatten(phigs::read_archive(source)))
                                     : describe_volume(session.read(source));
}

Reply run_surface(Session& session, const Arguments& arguments) {
    const std::string& name = arguments.words[0];
    const Volume& volume = session.volume();
    const std::optional<Surface> known = session.surface(name);
    const Surface wish = wished_surface(volume, known, arguments);
    if (known && !arguments.has("iso") && !arguments.has("table")) {
        session.set_colour(name, wish.colour);
    } else {
        session.set_surface(name, wish.isovalue, wish.table, wish.colour);
    }
    const SurfaceReport& report = session.report_of(name);
    Reply reply{surface_text(wish, report), surface_fields(wish, report)};
    if (report.triangles == 0) {
        reply.text += fmt::format("\nno surface there: the volume's values are {} .. {}",
                                  volume.minimum, volume.maximum);
    }
    return reply;
}

Reply run_remove(Session& session, const Arguments& arguments) {
    session.remove_surface(arguments.words[0]);
    return {"removed " + arguments.words[0], {{"removed", arguments.words[0]}}};
}

Reply run_view(Session& session, const Arguments& arguments) {
    Camera camera = session.scene.camera;
    if (arguments.words.size() == 1) {
        const auto angles = find_view(arguments.words[0]);
        if (!angles) {
            std::vector<std::string_view> names;
            for (const NamedView& view : named_views()) {
                names.push_back(view.name);
            }
            refuse(fmt::format("there is no view '{}'{}", arguments.words[0],
                               did_you_mean(arguments.words[0], names)));
        }
        camera.angles = *angles;
    } else if (arguments.words.size() == 2) {
        camera.angles = {parse_number("azimuth", arguments.words[0], -max_angle_deg, max_angle_deg),
                         parse_number("elevation", arguments.words[1], -90, 90)};
    }
    camera.zoom = arguments.number("zoom", camera.zoom, min_zoom, max_zoom);
    session.scene.camera = camera;
    return {fmt::format("azimuth {} elevation {} zoom {}", camera.angles.azimuth_deg,
                        camera.angles.elevation_deg, camera.zoom),
            {{"azimuth_deg", camera.angles.azimuth_deg},
             {"elevation_deg", camera.angles.elevation_deg},
             {"zoom", camera.zoom}}};
}

Reply run_light(Session& session, const Arguments& arguments) {
    auto& lights = session.scene.lights;
    const double number = parse_number("light", arguments.words[0], 1, max_lights);
    const auto index = static_cast<std::size_t>(number) - 1;
    if (number != std::floor(number) || index > lights.size()) {
        refuse(fmt::format("light {} cannot be set: {} are on; the next is {}", arguments.words[0],
                           lights.size(), lights.size() + 1));
    }
    if (arguments.words[1] == "off") {
        if (index < lights.size()) {
            lights.erase(lights.begin() + static_cast<std::ptrdiff_t>(index));
        }
    } else if (arguments.words.size() == 3) {
        const double before = index < lights.size() ? lights[index].intensity : 0.8;
        const Light light{
            parse_number("azimuth", arguments.words[1], -max_angle_deg, max_angle_deg),
            parse_number("elevation", arguments.words[2], -90, 90),
            arguments.number("intensity", before, 0, 4)};
        index < lights.size() ? lights[index] = light : lights.emplace_back(light);
    } else {
        refuse(fmt::format("light {}: give AZ EL or off, got '{}'", arguments.words[0],
                           arguments.words[1]));
    }
    return {fmt::format("{} of {} lights on", lights.size(), max_lights),
            {{"lights", static_cast<std::int64_t>(lights.size())}}};
}

Reply run_material(Session& session, const Arguments& arguments) {
    Material material = session.scene.material;
    material.ambient = arguments.number("ambient", material.ambient, 0, 1);
    material.specular = arguments.number("specular", material.specular, 0, 1);
    const double power = arguments.number("power", material.specular_power, 1, 128);
    material.specular_power = static_cast<std::uint32_t>(power);
    session.scene.material = material;
    return {fmt::format("ambient {} specular {} power {}", material.ambient, material.specular,
                        material.specular_power),
            {{"ambient", material.ambient},
             {"specular", material.specular},
             {"power", static_cast<std::int64_t>(material.specular_power)}}};
}

Reply run_background(Session& session, const Arguments& arguments) {
    session.scene.background = parse_colour(arguments.words[0]);
    return {"background " + arguments.words[0], {{"background", arguments.words[0]}}};
}

Reply run_size(Session& session, const Arguments& arguments) {
    session.scene.size = parse_size(arguments.words[0], 1, max_picture_px);
    return {"size " + arguments.words[0],
            {{"width", std::int64_t{session.scene.size.width}},
             {"height", std::int64_t{session.scene.size.height}}}};
}

Reply run_snapshot(Session& session, const Arguments& arguments) {
    const Picture picture = session.draw();
    const double draw_ms = session.last_frame().elapsed_ms;
    session.export_picture(picture, arguments.words[0], picture_text(session));
    return {fmt::format("wrote {} ({}x{}, drawn in {:.1f} ms)", arguments.words[0], picture.width,
                        picture.height, draw_ms),
            {{"file", arguments.words[0]},
             {"width", std::int64_t{picture.width}},
             {"height", std::int64_t{picture.height}},
             {"draw_ms", draw_ms}}};
}

Reply run_orbit(Session& session, const Arguments& arguments) {
    const double count = parse_number("frames", arguments.words[0], 1, max_orbit_frames);
    const std::string pattern = arguments.words.size() > 1 ? arguments.words[1] : "";
    if (!pattern.empty() && pattern.find("{}") == std::string::npos) {
        refuse(fmt::format("orbit: '{}' has no {{}} where the frame's number goes", pattern));
    }
    std::int64_t written = 0;
    const auto take = [&](int index, const Picture& picture) {
        if (pattern.empty()) {
            return;
        }
        std::string path = pattern;
        path.replace(path.find("{}"), 2, fmt::format("{:04}", index));
        session.export_picture(picture, path, picture_text(session));
        ++written;
    };
    const OrbitReport report = session.orbit(static_cast<int>(count), take);
    Reply reply{fmt::format("{} frames in {:.0f} ms", report.frames, report.elapsed_ms),
                {{"frames", std::int64_t{report.frames}},
                 {"elapsed_ms", report.elapsed_ms},
                 {"written", written}}};
    if (written != 0) {  // Most of the time went into writing: that is no rate of drawing.
        reply.text += fmt::format(", {} pictures written", written);
    } else {
        const double rate = report.frames * 1000.0 / report.elapsed_ms;
        reply.text += fmt::format(", {:.1f} frames/s", rate);
        reply.fields.push_back({"frames_per_s", rate});
    }
    return reply;
}

Reply run_stats(Session& session, const Arguments&) {
    Reply reply;
    std::vector<Fields> list;
    for (const Surface& surface : session.scene.surfaces) {
        const SurfaceReport& report = session.report_of(surface.name);
        reply.text +=
            surface_text(surface, report) +
            fmt::format("\n  {} cells crossed, {} of them ambiguous; {} cell rows skipped\n",
                        report.cells_active, report.cells_ambiguous, report.rows_skipped);
        list.push_back(surface_fields(surface, report));
    }
    if (const phigs::Content* archive = session.archive()) {
        reply.text += fmt::format("{}: {} triangles, {} spheres, {} lines\n", archive->file,
                                  archive->triangles, archive->spheres, archive->lines);
    }
    const FrameReport& frame = session.last_frame();
    reply.text +=
        fmt::format("last frame: {:.1f} ms, {} instructions, {} Renderer cycles (modelled)",
                    frame.elapsed_ms, frame.instructions, frame.renderer_cycles);
    reply.fields = {{"surfaces", list},
                    {"frame", Fields{{"elapsed_ms", frame.elapsed_ms},
                                     {"instructions", frame.instructions},
                                     {"renderer_cycles", frame.renderer_cycles}}}};
    return reply;
}

Reply run_digest(Session& session, const Arguments&) {
    const std::string frame = fmt::format("{:016x}", picture_digest(session.draw()));
    Reply reply{"frame " + frame, {{"frame", frame}}};
    Fields meshes;
    for (const Surface& surface : session.scene.surfaces) {
        const std::string mesh = fmt::format("{:016x}", session.mesh_digest(surface.name));
        reply.text += fmt::format("\nmesh {} {}", surface.name, mesh);
        meshes.push_back({surface.name, mesh});
    }
    reply.fields.push_back({"meshes", meshes});
    return reply;
}

Reply run_trace(Session& session, const Arguments& arguments) {
    if (arguments.words[0] != "save") {
        refuse(fmt::format("trace knows no '{}'; usage: trace save", arguments.words[0]));
    }
    const SavedTraces saved = session.save_traces();
    return {fmt::format("{} messages of {} nodes, {:.1f} MB, in {}", saved.messages, saved.nodes,
                        static_cast<double>(saved.bytes) / 1e6, saved.folder),
            {{"folder", saved.folder},
             {"nodes", std::int64_t{saved.nodes}},
             {"messages", static_cast<std::int64_t>(saved.messages)},
             {"bytes", static_cast<std::int64_t>(saved.bytes)}}};
}

Reply run_help(Session&, const Arguments& arguments) {
    Reply reply;
    std::vector<Fields> list;
    for (const Command& command : command_table()) {
        if (!arguments.words.empty() && find_command(arguments.words[0]).name != command.name) {
            continue;
        }
        reply.text += fmt::format("{}{} {}\n    {}", reply.text.empty() ? "" : "\n", command.name,
                                  command.arguments, command.help);
        list.push_back({{"name", std::string(command.name)},
                        {"arguments", std::string(command.arguments)},
                        {"help", std::string(command.help)}});
    }
    reply.fields = {{"commands", list}};
    return reply;
}

Reply run_quit(Session&, const Arguments&) {
    return {"", {}};
}

}  // namespace pxpl5::host
