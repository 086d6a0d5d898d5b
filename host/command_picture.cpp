// Commands that write pictures.
#include <fmt/core.h>

#include <algorithm>
#include <iterator>

#include "host/command_handlers.hpp"
#include "host/error.hpp"
#include "host/picture_text.hpp"

namespace pxpl5::host {

namespace {

constexpr int max_orbit_frames = 100'000;
constexpr int max_animation_frames = 2'000;

}  // namespace

Reply run_snapshot(Session& session, const Arguments& arguments) {
    const Picture picture = session.draw();
    const double draw_ms = session.last_frame().elapsed_ms;
    session.export_pictures({&picture, 1}, arguments.words[0],
                            picture_extras(session, session.scene.camera));
    const bool is_empty =
        std::ranges::count(picture.rgba, picture.rgba[0]) == std::ssize(picture.rgba);
    return {fmt::format("wrote {} ({}x{}, drawn in {:.1f} ms){}", arguments.words[0], picture.width,
                        picture.height, draw_ms, is_empty ? "; nothing is visible in it" : ""),
            {{"file", arguments.words[0]},
             {"width", std::int64_t{picture.width}},
             {"height", std::int64_t{picture.height}},
             {"draw_ms", draw_ms}}};
}

Reply run_orbit(Session& session, const Arguments& arguments) {
    const int count = parse_whole("frames", arguments.words[0], 1, max_orbit_frames);
    const std::string pattern = arguments.words.size() > 1 ? arguments.words[1] : "";
    const bool is_animation = pattern.ends_with(".gif");
    if (!pattern.empty() && !is_animation && pattern.find("{}") == std::string::npos) {
        refuse_command(fmt::format(
            "orbit: '{}' is no .gif and has no {{}} where the frame's number goes", pattern));
    }
    if (is_animation && count > max_animation_frames) {
        refuse_command(fmt::format("orbit: {} frames are too many for {}, {} are the most", count,
                                   pattern, max_animation_frames));
    }
    const int delay_ms = static_cast<int>(arguments.number("delay_ms", 40, 10, 60'000));
    std::int64_t written = 0;
    std::vector<Picture> pictures;
    const auto take = [&](int index, const Picture& picture, const Camera& camera) {
        if (is_animation) {
            pictures.push_back(picture);
        } else if (!pattern.empty()) {
            std::string path = pattern;
            path.replace(path.find("{}"), 2, fmt::format("{:04}", index));
            session.export_pictures({&picture, 1}, path, picture_extras(session, camera));
            ++written;
        }
    };
    const OrbitReport report = session.orbit(count, take);
    if (is_animation) {
        PictureExtras extras = animation_extras(session);
        extras.delay_ms = delay_ms;
        session.export_pictures(pictures, pattern, extras);
        written = 1;
    }
    Reply reply{fmt::format("{} frames in {:.0f} ms", report.frames, report.elapsed_ms),
                {{"frames", std::int64_t{report.frames}},
                 {"elapsed_ms", report.elapsed_ms},
                 {"written", written}}};
    if (written != 0 && !is_animation) {  // Most of the time went into writing.
        reply.text += fmt::format(", {} pictures written", written);
    } else {
        const double rate = report.frames * 1000.0 / report.elapsed_ms;
        reply.text +=
            fmt::format(", {:.1f} frames/s{}", rate, is_animation ? "; wrote " + pattern : "");
        reply.fields.push_back({"frames_per_s", rate});
    }
    return reply;
}

}  // namespace pxpl5::host
