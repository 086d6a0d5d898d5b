// Commands that ask about the volume and the picture, and change nothing.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <optional>

#include "host/base/error.hpp"
#include "host/commands/command_handlers.hpp"
#include "host/commands/text/picture_text.hpp"
#include "host/commands/text/volume_text.hpp"
#include "host/inspect/why/live_frame.hpp"
#include "host/session/transfer/detail.hpp"

namespace pxpl5::host {

namespace {

constexpr const char* usual_bins = "256";
static_assert(window_bins == 256, "a viewer takes its window from the usual bins");

struct Pixel {
    int x = 0, y = 0;
};

/// words[first] and the one behind it.
Pixel parse_pixel(const Session& session, const Arguments& arguments, std::size_t first) {
    const Size size = composed_size(session.scene.size, session.scene.stereo.mode);
    return {parse_whole("X", arguments.words[first], 0, size.width - 1),
            parse_whole("Y", arguments.words[first + 1], 0, size.height - 1)};
}

/// One end of a length.
struct End {
    glm::dvec3 p_mm{0};
    std::string surface;  ///< Empty for a place.

    std::string text() const {
        return (surface.empty() ? "" : surface + " at ") + place_text(p_mm);
    }
};

/// The end that words[at] begins: X,Y,Z in millimeters, or X and Y of a pixel. Moves `at` behind
/// it.
End take_end(Session& session, const Arguments& arguments, std::size_t& at,
             const std::string& wanted) {
    const std::size_t left = arguments.words.size() - at;
    if (left > 0 && arguments.words[at].find(',') != std::string::npos) {
        return {parse_triple("place", arguments.words[at++], -max_place_mm, max_place_mm), {}};
    }
    if (left < 2) {
        refuse_command("measure: give two ends, each X Y of a pixel or X,Y,Z in mm");
    }
    const Pixel pixel = parse_pixel(session, arguments, at);
    at += 2;
    const std::string surface = shown_surface(session, wanted);
    const auto picked = session.frames.pick(pixel.x, pixel.y, surface);
    if (!picked) {
        refuse_command(
            fmt::format("measure: no point of {} lies at pixel ({}, {}). Choose a pixel that shows "
                        "a surface, or give the place as X,Y,Z in mm",
                        surface.empty() ? "a surface" : surface, pixel.x, pixel.y));
    }
    return {picked->pick.p_mm,
            picked->plane ? "slice " + plane_text(*picked->plane) : picked->surface};
}

}  // namespace

Reply run_histogram(Session& session, const Arguments& arguments) {
    const int bins = parse_whole("BINS", arguments.words.empty() ? usual_bins : arguments.words[0]);
    const Volume& volume = session.volumes.volume();
    const Histogram counted = histogram(volume, bins);
    Reply reply{histogram_text(counted, volume.reduction), histogram_fields(counted)};
    if (volume.reduced) {
        add_warning(reply, fmt::format("the counts are those of the copy of the host, which has "
                                       "one voxel in {} along each axis; minimum and maximum are "
                                       "those of all voxels",
                                       volume.reduction));
    }
    reply.fields.push_back({"minimum", volume.minimum});
    reply.fields.push_back({"maximum", volume.maximum});
    reply.fields.push_back({"not_finite", static_cast<std::int64_t>(counted.not_finite)});
    reply.fields.push_back({"reduction", std::int64_t{volume.reduction}});
    return reply;
}

Reply run_measure(Session& session, const Arguments& arguments) {
    std::size_t at = 0;
    const End a = take_end(session, arguments, at, arguments.text("from", ""));
    const End b = take_end(session, arguments, at, arguments.text("to", ""));
    if (at < arguments.words.size()) {
        refuse_command(fmt::format("measure: '{}' follows two ends", arguments.words[at]));
    }
    const double distance_mm = glm::distance(a.p_mm, b.p_mm);
    return {fmt::format("{:.2f} mm in a straight line, from {} to {} mm LPS", distance_mm, a.text(),
                        b.text()),
            {{"a_mm", place_numbers(a.p_mm)},
             {"b_mm", place_numbers(b.p_mm)},
             {"distance_mm", distance_mm},
             {"a_surface", a.surface},
             {"b_surface", b.surface}}};
}

Reply run_why(Session& session, const Arguments& arguments) {
    const Pixel pixel = parse_pixel(session, arguments, 0);
    Reply reply = inspect::LiveFrame::of(session).why(pixel.x, pixel.y);
    const int samples = session.scene.samples;
    if (samples > 1) {
        reply.text = fmt::format(
            "Pictures show the mean of {} samples of the pixel; this explains one sample, at the "
            "pixel's center.\n{}",
            samples, reply.text);
    }
    if (const int detail = session.scene.detail.detail; detail > 0) {
        reply.text =
            fmt::format("Pictures are simplified (detail {}); this explains the exact surface.\n{}",
                        detail, reply.text);
    }
    reply.fields.push_back({"picture_samples", std::int64_t{samples}});
    reply.fields.push_back({"picture_detail", detail_word(session.scene.detail)});
    return reply;
}

}  // namespace pxpl5::host
