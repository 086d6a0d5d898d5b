#include "host/commands/text/picture_text.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>
#include <span>
#include <utility>

#include "host/base/chart_axis.hpp"
#include "host/base/digest.hpp"
#include "host/commands/text/volume_text.hpp"
#include "host/scene/overlay.hpp"
#include "host/session/transfer/detail.hpp"

namespace pxpl5::host {

namespace {

/// An archive has units of its own and no patient: its file's name alone.
std::vector<PictureMark> archive_marks(const Session& session) {
    const Color& back = session.scene.background;
    Overlay overlay;
    overlay.camera = session.scene.camera;
    overlay.subject = session.frames.subject();
    overlay.size = session.scene.size;
    overlay.background = {back.r, back.g, back.b};
    overlay.caption.title = session.volumes.archive()->file;
    overlay.letters = overlay.directions = overlay.scale = false;
    return overlay_marks(overlay);
}

using Attributes = std::vector<std::pair<std::string, std::string>>;

/// "simplified within 7.114 mm", or nothing for a picture of all triangles.
std::string simplified_text(const Session& session) {
    const double moved_mm = session.frames.last().moved_mm;
    return moved_mm > 0 ? fmt::format("simplified within {} mm", bound_text(moved_mm)) : "";
}

/// The volume's place in its time series. Empty without one.
std::string place_in_series(const Volume& volume, const std::optional<ShownVolumes>& shown) {
    return shown ? fmt::format("{} to {} of {}", shown->first, shown->last, volume.frames)
                 : time_place(volume);
}

/// The place comes first: where there is little room, the end is cut off.
std::string title_of(const Volume& volume, const std::optional<ShownVolumes>& shown) {
    const std::string place = place_in_series(volume, shown);
    return place.empty() ? volume.name : place + ": " + volume.name;
}

Caption caption_of(const Session& session, const std::optional<ShownVolumes>& shown = {}) {
    if (session.volumes.archive() != nullptr) {
        return {session.volumes.archive()->file, ""};
    }
    const Volume& volume = session.volumes.volume();
    std::string warning = place_warning(volume);
    if (const std::string simplified = simplified_text(session); !simplified.empty()) {
        warning += (warning.empty() ? "" : "; ") + simplified;
    }
    return {title_of(volume, shown), warning};
}

std::string spacing_text(const Volume& volume) {
    const glm::dvec3 spacing = spacing_mm(volume);
    return fmt::format("{:.6g}x{:.6g}x{:.6g}", spacing.x, spacing.y, spacing.z);
}

std::string view_text(const Camera& camera) {
    std::string text =
        fmt::format("azimuth {:.6g} elevation {:.6g} zoom {:.6g}", camera.angles.azimuth_deg,
                    camera.angles.elevation_deg, camera.zoom);
    if (camera.roll_deg != 0) {
        text += fmt::format(" roll {:.6g}", camera.roll_deg);
    }
    if (camera.pan_mm != glm::dvec2(0)) {
        text += fmt::format(" pan {:.6g},{:.6g}", camera.pan_mm.x, camera.pan_mm.y);
    }
    return text;
}

/// "anaglyph separation 30 convergence 600", in millimeters; empty for one camera.
std::string stereo_text(const Session& session, const Camera& camera) {
    const Stereo& stereo = session.scene.stereo;
    if (stereo.mode == StereoMode::off) {
        return "";
    }
    const EyePlaces places = eye_places(stereo, camera, session.frames.subject());
    return fmt::format("{} separation {:.6g} convergence {:.6g}", stereo_word(stereo.mode),
                       places.separation_mm, places.convergence_mm);
}

/// The texts of a file with two pictures. Its own attribute is the base line of an .mpo file.
void add_separation(PictureExtras& extras, const Session& session, const Camera& camera) {
    const EyePlaces places = eye_places(session.scene.stereo, camera, session.frames.subject());
    extras.attributes.emplace_back("separation_mm", fmt::format("{:.6g}", places.separation_mm));
}

/// Each eye's picture has the marks, at the distance of the screen.
void add_to_both(std::vector<PictureMark>& marks, const Scene& scene) {
    const int shift_px = composed_size(scene.size, scene.stereo.mode).width - scene.size.width;
    if (shift_px == 0) {
        return;
    }
    const std::vector<PictureMark> of_one = marks;
    for (PictureMark mark : of_one) {
        for (glm::vec2& point : mark.points) {
            point.x += static_cast<float>(shift_px);
        }
        marks.push_back(std::move(mark));
    }
}

/// The surfaces that the picture shows.
std::vector<Surface> drawn_surfaces(const Scene& scene) {
    std::vector<Surface> drawn;
    std::ranges::copy_if(scene.surfaces, std::back_inserter(drawn), [&scene](const Surface& each) {
        return each.visible && !is_compared(scene.surfaces, each);
    });
    return drawn;
}

std::string clips_text(const Scene& scene) {
    std::string text, last;
    for (const SceneClip& clip : scene.clips) {
        if (clip.words != std::exchange(last, clip.words)) {  // The six planes of a box are one.
            text += (text.empty() ? "" : "; ") + clip.words;
        }
    }
    return text;
}

/// "z 20, window 400 level 40"; empty without planes.
std::string planes_text(const Scene& scene) {
    std::string text;
    for (const ScenePlane& plane : scene.planes) {
        text += plane_text(plane) + ", ";
    }
    const auto& [width, level] = scene.planes_window;
    return text.empty() ? "" : text + fmt::format("window {:.6g} level {:.6g}", width, level);
}

std::string surface_text(const Surface& surface) {
    std::string text = fmt::format("{}={}", surface.name, surface.isovalue);
    if (surface.opacity < full_opacity) {
        text += fmt::format(" opacity {:.6g}", static_cast<double>(surface.opacity) / full_opacity);
    }
    if (surface.rim != 0) {
        text += fmt::format(" rim {:.6g}", static_cast<double>(surface.rim) / max_rim);
    }
    return text;
}

Attributes attributes_of(const Session& session, const Camera& camera) {
    Attributes attributes = {{"view", view_text(camera)},
                             {"samples", std::to_string(session.scene.samples)}};
    if (std::string stereo = stereo_text(session, camera); !stereo.empty()) {
        attributes.emplace_back("stereo", std::move(stereo));
    }
    if (const double moved_mm = session.frames.last().moved_mm; moved_mm > 0) {
        attributes.emplace_back("simplified_within_mm", bound_text(moved_mm));
    }
    if (!session.scene.clips.empty()) {
        attributes.emplace_back("clips", clips_text(session.scene));
    }
    if (!session.scene.planes.empty()) {
        attributes.emplace_back("slices", planes_text(session.scene));
    }
    if (session.volumes.archive() != nullptr) {
        attributes.emplace_back("scene", session.volumes.archive()->file);
        return attributes;
    }
    const Volume& volume = session.volumes.volume();
    attributes.emplace_back("volume", volume.source);
    attributes.emplace_back("dims", fmt::format("{}x{}x{}", volume.nx, volume.ny, volume.nz));
    attributes.emplace_back("spacing_mm", spacing_text(volume));
    attributes.emplace_back("axes", orientation_letters(volume));
    attributes.emplace_back("voxel_digest", fmt::format("{:016x}", volume.digest));
    attributes.emplace_back("gradient", enum_name(volume.gradient));
    if (!volume.series.empty()) {
        attributes.emplace_back("series", volume.series);
    }
    std::string isovalues;
    for (const Surface& surface : drawn_surfaces(session.scene)) {
        isovalues += (isovalues.empty() ? "" : ", ") + surface_text(surface);
    }
    attributes.emplace_back("isovalues", isovalues);
    return attributes;
}

/// The same in one line, for formats with one text only.
/// swept  The surface whose isovalue changes; null if none does.
std::string describe_scene(const Session& session, const Camera& camera,
                           const AnimationRange& range = {}) {
    const Scene& scene = session.scene;
    std::string text;
    if (const ArchiveFacts* archive = session.volumes.archive()) {
        text = fmt::format("scene {}, {} triangles, {} spheres, {} lines", archive->file,
                           archive->triangles, archive->spheres, archive->lines);
    } else {
        const Volume& volume = session.volumes.volume();
        text = fmt::format("volume {} {}x{}x{} spacing {} mm", title_of(volume, range.volumes),
                           volume.nx, volume.ny, volume.nz, spacing_text(volume));
        if (volume.gradient == GradientKernel::smooth) {
            text += "; gradient smooth";
        }
    }
    text += "; view " + view_text(camera);
    if (const std::string stereo = stereo_text(session, camera); !stereo.empty()) {
        text += "; stereo " + stereo;
    }
    for (const Surface& surface : drawn_surfaces(scene)) {
        const bool is_swept = range.swept && range.swept->name == surface.name;
        text += is_swept ? fmt::format("; surface {} isovalues {} to {}", surface.name,
                                       range.swept->first, range.swept->last)
                         : fmt::format("; surface {} isovalue {}", surface.name, surface.isovalue);
    }
    if (!scene.clips.empty()) {
        text += "; clip " + clips_text(scene);
    }
    if (!scene.planes.empty()) {
        text += "; slices " + planes_text(scene);
    }
    if (const std::string simplified = simplified_text(session); !simplified.empty()) {
        text += "; " + simplified;
    }
    return text;
}

}  // namespace

PictureExtras picture_extras(const Session& session, const Camera& camera, EyesInFile eyes) {
    PictureExtras extras{describe_scene(session, camera), attributes_of(session, camera), {}, 40};
    if (eyes == EyesInFile::apart) {
        add_separation(extras, session, camera);
    }
    if (session.scene.overlay) {
        Scene seen = session.scene;
        seen.camera = camera;
        for (Surface& surface : seen.surfaces) {
            surface.visible = surface.visible && !is_compared(session.scene.surfaces, surface);
        }
        if (seen.surfaces.empty() && seen.planes.empty() && session.volumes.archive() == nullptr) {
            return extras;  // Nothing to explain.
        }
        extras.marks = session.volumes.archive() != nullptr
                           ? archive_marks(session)
                           : overlay_marks(seen, session.frames.subject(), caption_of(session));
        if (eyes == EyesInFile::composed) {
            add_to_both(extras.marks, session.scene);
        }
    }
    return extras;
}

PictureExtras animation_extras(const Session& session, const AnimationRange& range) {
    const Scene& scene = session.scene;
    const std::optional<SweptSurface>& swept = range.swept;
    PictureExtras extras{describe_scene(session, scene.camera, range), {}, {}};
    if (scene.overlay) {
        Overlay overlay;
        overlay.camera = scene.camera;
        overlay.subject = session.frames.subject();
        overlay.size = scene.size;
        overlay.background = {scene.background.r, scene.background.g, scene.background.b};
        overlay.caption = caption_of(session, range.volumes);
        for (const Surface& surface : scene.surfaces) {
            for (LegendLine& line : legend_of({&surface, 1})) {
                if (swept && swept->name == surface.name) {
                    line.text =
                        fmt::format("{}  {:.6g} to {:.6g}", swept->name, swept->first, swept->last);
                }
                overlay.legend.push_back(std::move(line));
            }
        }
        overlay.letters = overlay.directions = false;
        extras.marks = overlay_marks(overlay);
        add_to_both(extras.marks, scene);
    }
    return extras;
}

std::uint64_t picture_digest(const Picture& picture) {
    Digest digest;
    digest.add(std::as_bytes(std::span(picture.rgba)));
    return digest.value();
}

Reply describe_archive(const ArchiveFacts& content) {
    const glm::dvec3 &low = content.low, &high = content.high;
    Reply reply;
    reply.text = fmt::format(
        "{}: {}, {} posted; {} ({}), {}, {} in {}\nfrom ({:.6g}, {:.6g}, {:.6g}) to ({:.6g}, "
        "{:.6g}, {:.6g}) in its own units",
        content.file, counted(content.structures, "structure"), content.posted,
        counted(content.polygons, "polygon"), counted(content.triangles, "triangle"),
        counted(content.spheres, "sphere"), counted(content.lines, "line"),
        counted(content.materials.size(), "color"), low.x, low.y, low.z, high.x, high.y, high.z);
    std::vector<Fields> notes;
    for (const std::string& note : content.notes) {
        add_warning(reply, note, "\nnote: ");
        notes.push_back({{"note", note}});
    }
    const auto number = [](std::size_t value) { return static_cast<std::int64_t>(value); };
    reply.fields = {{"name", content.file},
                    {"structures", number(content.structures)},
                    {"posted", number(content.posted)},
                    {"polygons", number(content.polygons)},
                    {"triangles", number(content.triangles)},
                    {"spheres", number(content.spheres)},
                    {"lines", number(content.lines)},
                    {"colors", number(content.materials.size())},
                    {"low", std::vector<double>{low.x, low.y, low.z}},
                    {"high", std::vector<double>{high.x, high.y, high.z}},
                    {"notes", notes}};
    return reply;
}

}  // namespace pxpl5::host
