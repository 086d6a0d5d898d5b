// Commands about how the scene is looked at.
#include <fmt/core.h>
#include <fmt/format.h>

#include <cmath>

#include "host/base/error.hpp"
#include "host/base/nearest.hpp"
#include "host/commands/command_handlers.hpp"
#include "host/commands/fit_view.hpp"
#include "host/commands/pictures/picture_settings.hpp"
#include "host/commands/text/volume_text.hpp"
#include "host/scene/clip.hpp"
#include "host/session/transfer/detail.hpp"

namespace pxpl5::host {

namespace {

constexpr double max_pan_mm = 1e5;
constexpr std::size_t box_planes = 6;  ///< In a row.

/// "X,Y" in millimeters.
glm::dvec2 parse_pan(const std::string& text) {
    const std::size_t comma = text.find(',');
    if (comma == std::string::npos) {
        refuse_command(fmt::format("pan: '{}' is not of the form X,Y", text));
    }
    return {parse_number("pan to the right", text.substr(0, comma), -max_pan_mm, max_pan_mm),
            parse_number("pan upwards", text.substr(comma + 1), -max_pan_mm, max_pan_mm)};
}

/// Roll and pan, if there are any.
std::string turn_text(const Camera& camera) {
    const glm::dvec2& pan = camera.pan_mm;
    return (camera.roll_deg == 0 ? "" : fmt::format(" roll {}", camera.roll_deg)) +
           (pan == glm::dvec2(0) ? "" : fmt::format(" pan {},{} mm", pan.x, pan.y));
}

Reply describe_clips(const Session& session) {
    Reply reply;
    std::vector<Fields> list;
    for (std::size_t i = 0; i < session.scene.clips.size(); ++i) {
        const SceneClip& clip = session.scene.clips[i];
        if (clip.words.starts_with("box")) {
            i += box_planes - 1;
        }
        reply.text += fmt::format("{}clip {}", reply.text.empty() ? "" : "\n", clip.words);
        list.push_back({{"clip", clip.words}});
    }
    if (list.empty()) {
        reply.text = "nothing is cut off";
    }
    reply.fields = {{"clips", list}};
    return reply;
}

/// Takes away what `kind`, a letter or "box", has cut; all for "off". Returns whether there was
/// any.
bool end_clip(Scene& scene, const std::string& kind) {
    return std::erase_if(scene.clips, [&](const SceneClip& clip) {
               return kind == "off" || clip.words.substr(0, clip.words.find(' ')) == kind;
           }) != 0;
}

/// Across a patient's axis, through a place in millimeters or the volume's center.
void add_plane(Session& session, const Arguments& arguments) {
    const std::string& letter = arguments.words[0];
    double at_mm = 0;
    if (arguments.words.size() > 1) {
        at_mm = parse_number("place", arguments.words[1], -max_place_mm, max_place_mm);
    } else if (const auto unit = letter.size() == 1 ? axis_plane(letter[0], 1) : std::nullopt) {
        // Rounded, so that the words name the whole place.
        const double center_mm = glm::dot(session.frames.subject().center_mm, glm::dvec3(*unit));
        at_mm = parse_number("place", fmt::format("{:.6g}", center_mm));
    }
    const auto plane = letter.size() == 1 ? axis_plane(letter[0], at_mm) : std::nullopt;
    if (!plane) {
        refuse_command(
            fmt::format("clip: '{}' is none of L R P A S I, box, off: the letter names the side "
                        "that is kept",
                        letter));
    }
    end_clip(session.scene, letter);
    session.scene.clips.push_back({fmt::format("{} {}", letter, at_mm), *plane});
}

/// Keeps the other side of a plane, which stays at its place.
void flip_plane(Session& session, const std::string& letter) {
    constexpr std::string_view letters = "LRPASI";  // Opposite sides are neighbors.
    const auto clip = std::ranges::find_if(session.scene.clips, [&](const SceneClip& each) {
        return each.words.starts_with(letter + " ");
    });
    const std::size_t side = letter.size() == 1 ? letters.find(letter[0]) : std::string_view::npos;
    if (clip == session.scene.clips.end() || side == std::string_view::npos) {
        refuse_command(fmt::format("clip: no plane '{}' cuts; 'clip' lists those that do", letter));
    }
    const double at_mm = parse_number("place", clip->words.substr(2));
    add_plane(session,
              {"clip", {std::string(1, letters[side ^ 1U]), fmt::format("{}", 0 - at_mm)}, {}});
    end_clip(session.scene, letter);
}

void add_box(Session& session, const Arguments& arguments) {
    const Volume& volume = session.volumes.volume();
    if (arguments.words.size() != 3) {
        refuse_command("clip box: give two corner voxels, as clip box 10,10,0 90,90,40");
    }
    const glm::dvec3 first = parse_triple("first corner", arguments.words[1], -1e5, 1e5);
    const glm::dvec3 last = parse_triple("last corner", arguments.words[2], -1e5, 1e5);
    try {
        const BoxPlanes planes =
            box_planes_voxels(first, last, {volume.voxel_to_patient, volume.slice_places});
        end_clip(session.scene, "box");
        for (const glm::dvec4& plane : planes) {
            session.scene.clips.push_back(
                {fmt::format("box {} {}", arguments.words[1], arguments.words[2]), plane});
        }
    } catch (const std::invalid_argument& error) {
        refuse_command(std::string("clip box: ") + error.what());
    }
}

}  // namespace

Reply run_view(Session& session, const Arguments& arguments) {
    Camera camera = session.scene.camera;
    if (arguments.words.size() == 1) {
        const auto angles = find_view(arguments.words[0]);
        if (!angles) {
            std::vector<std::string_view> names;
            for (const NamedView& view : named_views()) {
                names.push_back(view.name);
            }
            refuse_command(fmt::format("there is no view '{}'{}", arguments.words[0],
                                       did_you_mean(arguments.words[0], names)));
        }
        camera.angles = *angles;
        camera.roll_deg = 0;
        camera.pan_mm = {};
    } else if (arguments.words.size() == 2) {
        camera.angles = {parse_number("azimuth", arguments.words[0], -max_angle_deg, max_angle_deg),
                         parse_number("elevation", arguments.words[1], -90, 90)};
    }
    camera.zoom = arguments.number("zoom", camera.zoom);
    camera.roll_deg = arguments.number("roll", camera.roll_deg);
    if (arguments.has("pan")) {
        camera.pan_mm = parse_pan(arguments.text("pan", ""));
    }
    if (arguments.text("fit", "no") == "yes") {
        camera = fitted_to_surfaces(session, camera);
    }
    session.scene.camera = camera;
    return {fmt::format("azimuth {} elevation {} zoom {}", camera.angles.azimuth_deg,
                        camera.angles.elevation_deg, camera.zoom) +
                turn_text(camera),
            {{"azimuth_deg", camera.angles.azimuth_deg},
             {"elevation_deg", camera.angles.elevation_deg},
             {"zoom", camera.zoom},
             {"roll_deg", camera.roll_deg},
             {"pan_mm", std::vector<double>{camera.pan_mm.x, camera.pan_mm.y}}}};
}

Reply run_background(Session& session, const Arguments& arguments) {
    session.scene.background = parse_color(arguments.words[0]);
    return {"background " + arguments.words[0], {{"background", arguments.words[0]}}};
}

Reply run_size(Session& session, const Arguments& arguments) {
    session.scene.size = parse_size(arguments.words[0], 1, max_user_picture_px);
    return {"size " + arguments.words[0],
            {{"width", std::int64_t{session.scene.size.width}},
             {"height", std::int64_t{session.scene.size.height}}}};
}

Reply run_clip(Session& session, const Arguments& arguments) {
    if (arguments.words.empty()) {
        return describe_clips(session);
    }
    const std::string& kind = arguments.words[0];
    if (arguments.words.back() == "off") {
        if (!end_clip(session.scene, kind) && kind != "off") {
            refuse_command(
                fmt::format("clip: no plane '{}' cuts; 'clip' lists those that do", kind));
        }
    } else if (arguments.words.back() == "flip") {
        flip_plane(session, kind);
    } else if (kind == "box") {
        add_box(session, arguments);
    } else {
        add_plane(session, arguments);
    }
    static_assert(6 + box_planes <= max_clip_planes, "one plane of each letter, and a box");
    return describe_clips(session);
}

Reply run_antialias(Session& session, const Arguments& arguments) {
    const int samples = parse_samples(arguments.name, arguments.words[0]);
    session.scene.samples = samples;
    return {fmt::format("{} sample{} per pixel", samples, samples == 1 ? "" : "s"),
            {{"samples", std::int64_t{samples}}}};
}

Reply run_detail(Session& session, const Arguments& arguments) {
    DetailChoice& choice = session.scene.detail;
    const std::string refusal = session.frames.simplification_refusal();
    if (!arguments.words.empty()) {
        const std::string& word = arguments.words[0];
        DetailChoice wanted{word == "auto", 0};
        if (word != "auto" && word != "exact") {
            wanted.detail = parse_whole("detail", word, 1, max_detail);
            if (!refusal.empty()) {
                throw RequestError(ExitCode::failed, fmt::format("detail {}: {}", word, refusal));
            }
        }
        choice = wanted;
    }
    Reply reply;
    reply.text =
        choice.is_auto ? fmt::format(
                             "detail auto: the viewer's moving pictures are simplified where "
                             "they have more than {} triangles, all others are exact",
                             moving_triangles)
        : choice.detail == 0 ? "detail exact: all pictures have all triangles"
                             : fmt::format(
                                   "detail {}: all pictures are simplified in cells of {} voxels a "
                                   "side",
                                   choice.detail, 1 << choice.detail);
    reply.fields = {{"detail", detail_word(choice)}};
    const bool is_exact_yet = (choice.is_auto || choice.detail > 0) && !refusal.empty();
    reply.fields.push_back({"refused", is_exact_yet});
    if (is_exact_yet) {
        add_warning(reply, "all pictures are exact: " + refusal);
    }
    return reply;
}

Reply run_stereo(Session& session, const Arguments& arguments) {
    Stereo& stereo = session.scene.stereo;
    if (!arguments.words.empty()) {
        const std::optional<StereoMode> mode = find_stereo(arguments.words[0]);
        if (!mode) {  // The only other word of the table.
            refuse_command(
                "stereo: a headset is no mode of the pictures. Its eyes follow the head: open the "
                "page of `pxpl5 serve` in the headset's browser and press the headset button");
        }
        stereo = {*mode, arguments.number("separation", 0), arguments.number("convergence", 0)};
    } else if (!arguments.options.empty()) {
        refuse_command("stereo: options need a mode, for example: stereo anaglyph separation=30");
    }
    const std::string mode(stereo_word(stereo.mode));
    Reply reply{"stereo " + mode, {{"stereo", mode}}};
    const bool has_subject = session.volumes.has_volume() || session.volumes.archive() != nullptr;
    if (stereo.mode == StereoMode::off || !has_subject) {
        return reply;
    }
    const EyePlaces places = eye_places(stereo, session.scene.camera, session.frames.subject());
    reply.text += fmt::format(": eyes {:.4g} mm apart, parallax 0 at {:.4g} mm",
                              places.separation_mm, places.convergence_mm);
    reply.fields.push_back({"separation_mm", places.separation_mm});
    reply.fields.push_back({"convergence_mm", places.convergence_mm});
    return reply;
}

Reply run_overlay(Session& session, const Arguments& arguments) {
    session.scene.overlay = arguments.words[0] == "on";
    return {"overlay " + arguments.words[0], {{"overlay", session.scene.overlay}}};
}

Reply run_tint(Session& session, const Arguments& arguments) {
    const std::size_t gaps = session.volumes.volume().gap_slabs.size();
    if (arguments.has("color")) {
        session.scene.gap_color = parse_color(arguments.text("color", ""));
    }
    session.scene.tint_gaps = arguments.words[0] == "gaps";
    return {fmt::format("tint {}: the volume has {} gap{}", arguments.words[0], gaps,
                        gaps == 1 ? "" : "s"),
            {{"tint_gaps", session.scene.tint_gaps}, {"gaps", static_cast<std::int64_t>(gaps)}}};
}

std::string shown_surface(const Session& session, const std::string& name) {
    if (name.empty()) {
        return name;
    }
    const Surface& surface = session.meshes.surface(name);
    if (!surface.visible) {
        refuse_command(
            fmt::format("{} is hidden; `surface {} visible=yes` shows the surface", name, name));
    }
    if (is_compared(session.scene.surfaces, surface)) {
        refuse_command(
            fmt::format("`compare` shows two other surfaces in place of {}; `compare {} "
                        "off` shows the surface",
                        name, name));
    }
    return name;
}

namespace {

Fields fields_of(const Session& session, const Frames::Picked& hit) {
    const Pick& pick = hit.pick;
    Fields fields = {{"surface", hit.surface}};
    if (hit.plane) {
        fields.push_back({"slice", plane_fields(*hit.plane)});
    } else {
        fields.push_back({"isovalue", session.meshes.surface(hit.surface).isovalue});
    }
    fields.push_back({"p_mm", std::vector<double>{pick.p_mm.x, pick.p_mm.y, pick.p_mm.z}});
    fields.push_back(
        {"p_voxel", std::vector<double>{pick.p_voxel.x, pick.p_voxel.y, pick.p_voxel.z}});
    fields.push_back({"voxel", std::vector<std::int64_t>{pick.x, pick.y, pick.z}});
    if (pick.value) {
        fields.push_back({"value", *pick.value});
    }
    if (pick.value_between) {
        fields.push_back({"value_between", *pick.value_between});
    }
    return fields;
}

/// "skin" or "slice z 20".
std::string name_of(const Frames::Picked& hit) {
    return hit.plane ? "slice " + plane_text(*hit.plane) : hit.surface;
}

std::vector<Fields> fields_of(const Session& session, const std::vector<Frames::Picked>& hits) {
    std::vector<Fields> list;
    for (const Frames::Picked& hit : hits) {
        list.push_back(fields_of(session, hit));
    }
    return list;
}

}  // namespace

Reply run_pick(Session& session, const Arguments& arguments) {
    const Size size = composed_size(session.scene.size, session.scene.stereo.mode);
    const int x = parse_whole("X", arguments.words[0], 0, size.width - 1);
    const int y = parse_whole("Y", arguments.words[1], 0, size.height - 1);
    const std::string wanted = shown_surface(session, arguments.text("surface", ""));
    std::vector<Frames::Picked> hits = session.frames.hits(x, y);
    for (Frames::Picked& hit : hits) {
        session.voxels.add_values(hit.pick);
    }
    const auto picked = Frames::chosen(hits, wanted);
    if (!picked) {
        return {wanted.empty() ? fmt::format("nothing at ({}, {}): the background", x, y)
                               : fmt::format("no point of {} lies at ({}, {})", wanted, x, y),
                {{"hit", false}, {"hits", fields_of(session, hits)}}};
    }
    const Pick& pick = picked->pick;
    Reply reply;
    const std::string isovalue =
        picked->plane
            ? ""
            : fmt::format("isovalue {:.7g}, ", session.meshes.surface(picked->surface).isovalue);
    reply.text =
        fmt::format("{} at {} mm LPS; {}nearest voxel ({}, {}, {}) has {}", name_of(*picked),
                    place_text(pick.p_mm), isovalue, pick.x, pick.y, pick.z,
                    pick.value ? fmt::format("{:.7g}", *pick.value) : "no value known");
    std::string_view where = "in front";  // The hits are sorted, nearest first.
    for (const Frames::Picked& hit : hits) {
        if (hit.surface == picked->surface && hit.plane == picked->plane) {
            where = "behind";
            continue;
        }
        reply.text +=
            fmt::format("\n{}: {} at {} mm LPS", where, name_of(hit), place_text(hit.pick.p_mm));
    }
    reply.fields = {{"hit", true}};
    for (Field& field : fields_of(session, *picked)) {
        reply.fields.push_back(std::move(field));
    }
    reply.fields.push_back({"hits", fields_of(session, hits)});
    if (arguments.text("part", "no") == "yes") {
        if (picked->plane) {
            add_warning(reply, fmt::format("a slice has no parts, and {} is at ({}, {}); name the "
                                           "surface, as in surface=NAME",
                                           name_of(*picked), x, y));
        } else {
            add_part(session, picked->surface, pick.p_mm, reply);
        }
    }
    // The nearest voxel's value would give a surface that does not pass through the point.
    if (arguments.has("set") && pick.value_between) {
        Arguments surface;
        surface.name = "surface";
        surface.words = {arguments.text("set", "")};
        surface.options["iso"] = fmt::format("{:.7g}", *pick.value_between);
        const Reply built = run_surface(session, surface);
        reply.text += "\n" + built.text;
        reply.fields.push_back({"set", built.fields});
    }
    return reply;
}

}  // namespace pxpl5::host
