#include "host/commands/text/scene_script.hpp"

#include <fmt/core.h>

#include <filesystem>

#include "host/base/command_line.hpp"
#include "host/phantom/phantom.hpp"
#include "host/session/transfer/detail.hpp"
#include "host/volume/identity.hpp"

namespace pxpl5::host {

namespace {

using Options = std::map<std::string, std::string>;

/// The shortest text of which the same number is read.
std::string exact(double value) {
    return fmt::format("{}", value);
}

std::string color_word(const Color& color) {
    return fmt::format("#{:02x}{:02x}{:02x}", color.r, color.g, color.b);
}

Options options_of(const Stereo& stereo) {
    Options options;
    if (stereo.separation_mm > 0) {
        options["separation"] = exact(stereo.separation_mm);
    }
    if (stereo.convergence_mm > 0) {
        options["convergence"] = exact(stereo.convergence_mm);
    }
    return options;
}

class Lines {
  public:
    void add(const std::string& name, std::vector<std::string> words, Options options = {}) {
        text_ += to_line({name, std::move(words), std::move(options)}) + '\n';
    }
    const std::string& text() const { return text_; }

  private:
    std::string text_;
};

/// The load, with the whole path: the script may be played in another folder.
void add_load(const Session& session, Lines& lines) {
    const std::optional<std::string>& line = session.history.load_line();
    if (!line) {
        return;
    }
    Arguments load = parse_line(*line);
    if (session.volumes.has_volume()) {
        const Volume& volume = session.volumes.volume();
        load.words.at(0) = is_phantom(load.words.at(0)) ? load.words.at(0) : volume.source;
        if (volume.frames > 1) {
            load.options["frame"] = std::to_string(volume.frame);
        }
        lines.add(load.name, load.words, load.options);
        if (volume.digest != 0) {
            lines.add("info", {},
                      {{"digest", fmt::format("{:016x}", volume.digest)},
                       {"place", fmt::format("{:016x}", place_digest(volume))}});
        }
    } else {
        load.words.at(0) = std::filesystem::absolute(load.words.at(0)).lexically_normal().string();
        lines.add(load.name, load.words, load.options);
    }
}

Options style_of(const Surface& surface) {
    Options style = {{"color", color_word(surface.color)},
                     {"opacity", exact(static_cast<double>(surface.opacity) / full_opacity)},
                     {"visible", surface.visible ? "yes" : "no"}};
    if (surface.rim != 0) {
        style["rim"] = exact(static_cast<double>(surface.rim) / max_rim);
    }
    return style;
}

/// The option that selects components.
Options selection_of(const ComponentFilter& filter) {
    switch (filter.kind) {
        case ComponentFilter::Kind::largest:
            return {{"show", "largest"}};
        case ComponentFilter::Kind::at_least_mm2:
            return {{"min_mm2", exact(filter.least)}};
        case ComponentFilter::Kind::at_least_ml:
            return {{"min_ml", exact(filter.least)}};
        case ComponentFilter::Kind::at_point:
            return {
                {"at_mm", fmt::format("{},{},{}", filter.p_mm.x, filter.p_mm.y, filter.p_mm.z)}};
        case ComponentFilter::Kind::all:
            break;
    }
    return {};
}

Options filter_of(const ComponentFilter& filter) {
    Options options = selection_of(filter);
    if (filter.fills_cavities) {
        options["cavities"] = "no";
    }
    return options;
}

/// In drawing order: which of two surfaces at one depth is seen depends on the order.
void add_surfaces(const Scene& scene, Lines& lines) {
    std::string compared;
    for (const Surface& surface : scene.surfaces) {
        Options options = style_of(surface);
        if (surface.compared_with.empty()) {
            options["iso"] = exact(surface.isovalue);
            options["table"] = enum_name(surface.table);
        } else if (surface.compared_with != std::exchange(compared, surface.compared_with)) {
            lines.add("compare", {compared});  // Makes two surfaces, which follow each other.
        }
        lines.add("surface", {surface.name}, options);
        if (const Options filter = filter_of(surface.components); !filter.empty()) {
            lines.add("components", {surface.name}, filter);
        }
    }
}

void add_clips(const Scene& scene, Lines& lines) {
    std::string last;
    for (const SceneClip& clip : scene.clips) {
        if (clip.words != std::exchange(last, clip.words)) {  // The six planes of a box are one.
            const Arguments words = parse_line("clip " + clip.words);
            lines.add(words.name, words.words);
        }
    }
}

void add_planes(const Scene& scene, Lines& lines) {
    if (scene.planes.empty()) {
        return;
    }
    Options options = {{"window", exact(scene.planes_window.width)},
                       {"level", exact(scene.planes_window.level)}};
    for (const ScenePlane& plane : scene.planes) {
        options[std::string(1, "xyz"[plane.axis])] = std::to_string(plane.index);
    }
    lines.add("planes", {}, options);
}

void add_looks(const Scene& scene, Lines& lines) {
    lines.add("light", {"off"});
    int number = 1;
    for (const Light& light : scene.lights) {
        lines.add("light",
                  {std::to_string(number++), exact(light.azimuth_deg), exact(light.elevation_deg)},
                  {{"intensity", exact(light.intensity)}});
    }
    const Material& material = scene.material;
    lines.add("material", {},
              {{"ambient", exact(material.ambient)},
               {"specular", exact(material.specular)},
               {"power", std::to_string(material.specular_power)}});
    lines.add("background", {color_word(scene.background)});
    lines.add("antialias", {std::to_string(scene.samples)});
    lines.add("detail", {detail_word(scene.detail)});
    lines.add("stereo", {std::string(stereo_word(scene.stereo.mode))}, options_of(scene.stereo));
    lines.add("overlay", {scene.overlay ? "on" : "off"});
    lines.add("size", {fmt::format("{}x{}", scene.size.width, scene.size.height)});
    const Camera& camera = scene.camera;
    lines.add("view", {exact(camera.angles.azimuth_deg), exact(camera.angles.elevation_deg)},
              {{"zoom", exact(camera.zoom)},
               {"roll", exact(camera.roll_deg)},
               {"pan", fmt::format("{},{}", camera.pan_mm.x, camera.pan_mm.y)}});
}

}  // namespace

std::string scene_script(const Session& session) {
    const Scene& scene = session.scene;
    Lines lines;
    add_load(session, lines);
    if (session.volumes.has_volume()) {
        lines.add("tint", {scene.tint_gaps ? "gaps" : "off"},
                  {{"color", color_word(scene.gap_color)}});
        add_surfaces(scene, lines);
        add_clips(scene, lines);
        add_planes(scene, lines);
    }
    add_looks(scene, lines);
    return lines.text();
}

}  // namespace pxpl5::host
