// The command that shows slices in pictures of the surfaces.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/commands/command_handlers.hpp"
#include "host/commands/text/volume_text.hpp"

namespace pxpl5::host {

namespace {

Reply describe_planes(const Scene& scene) {
    Reply reply;
    std::vector<Fields> list;
    for (const ScenePlane& plane : scene.planes) {
        reply.text += (list.empty() ? "slices " : ", ") + plane_text(plane);
        list.push_back(plane_fields(plane));
    }
    const auto& [width, level] = scene.planes_window;
    if (list.empty()) {
        reply.text = "pictures show no slices";
    } else {
        reply.text += fmt::format(" in pictures, window {:.6g} level {:.6g}", width, level);
    }
    reply.fields = {{"planes", list}};
    if (!list.empty()) {
        reply.fields.push_back({"window", width});
        reply.fields.push_back({"level", level});
    }
    return reply;
}

int checked_index(const Volume& volume, int axis, const std::string& text) {
    const int count = axis == 0 ? volume.nx : axis == 1 ? volume.ny : volume.nz;
    const char letter = "xyz"[axis];
    if (text.empty() || text.find_first_not_of("-0123456789") != std::string::npos) {
        refuse_command(
            fmt::format("planes: {} is '{}', must be the number of a slice, 0 to {}, "
                        "or off",
                        letter, text, count - 1));
    }
    const int index = parse_whole(fmt::format("planes: {}", letter), text);
    if (index < 0 || index >= count) {
        refuse_command(fmt::format("planes: {} has no slice {} along {}: give 0 to {}, or off",
                                   volume.source, index, letter, count - 1));
    }
    return index;
}

/// The gray window that the options give. A missing option keeps the value of the slices in the
/// picture; without slices it has the value that the command `slice` begins with.
GrayWindow checked_window(Session& session, const Arguments& arguments) {
    const GrayWindow& held = session.scene.planes_window;
    const GrayWindow window = session.scene.planes.empty()
                                  ? window_of(session, arguments)
                                  : GrayWindow{arguments.number("window", held.width),
                                               arguments.number("level", held.level)};
    const auto& [width, level] = window;
    const bool fits = width <= most_window && std::abs(level) <= most_window;
    if (!fits || !(level - width / 2 < level + width / 2)) {
        refuse_command(
            fmt::format("planes: a window of {:.6g} around {:.6g} is too {} for the "
                        "machine; give others, as in window=400 level=40",
                        width, level, fits ? "narrow" : "large"));
    }
    return window;
}

}  // namespace

Reply run_planes(Session& session, const Arguments& arguments) {
    const Volume& volume = session.volumes.volume();
    Scene& scene = session.scene;
    if (!arguments.words.empty()) {
        if (!arguments.options.empty()) {
            refuse_command("planes off: takes no options");
        }
        scene.planes.clear();
    }
    if (arguments.options.empty()) {
        return describe_planes(scene);
    }
    std::vector<ScenePlane> planes = scene.planes;
    for (int axis = 0; axis < 3; ++axis) {
        const std::string letter(1, "xyz"[axis]);
        if (!arguments.has(letter)) {
            continue;
        }
        std::erase_if(planes, [&](const ScenePlane& plane) { return plane.axis == axis; });
        if (const std::string text = arguments.text(letter, ""); text != "off") {
            planes.push_back({axis, checked_index(volume, axis, text)});
        }
    }
    std::ranges::sort(planes, {}, &ScenePlane::axis);
    if (!planes.empty()) {
        scene.planes_window = checked_window(session, arguments);
    } else if (arguments.has("window") || arguments.has("level")) {
        refuse_command(
            "planes: the window is that of slices in the picture, and there is none; "
            "add one, for example planes z=10");
    }
    scene.planes = std::move(planes);
    return describe_planes(scene);
}

}  // namespace pxpl5::host
