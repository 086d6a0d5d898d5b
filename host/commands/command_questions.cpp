// Commands that ask about the volume and the picture, and change nothing.
#include <fmt/core.h>

#include <glm/geometric.hpp>

#include "host/base/error.hpp"
#include "host/commands/command_handlers.hpp"
#include "host/commands/text/picture_text.hpp"
#include "host/commands/text/slice_picture.hpp"
#include "host/commands/text/volume_text.hpp"
#include "host/inspect/why/live_frame.hpp"

namespace pxpl5::host {

namespace {

constexpr const char* usual_bins = "256";

std::vector<double> point(const glm::dvec3& p) {
    return {p.x, p.y, p.z};
}

struct Pixel {
    int x = 0, y = 0;
};

/// words[first] and the one behind it.
Pixel parse_pixel(const Session& session, const Arguments& arguments, std::size_t first) {
    const Size& size = session.scene.size;
    return {parse_whole("X", arguments.words[first], 0, size.width - 1),
            parse_whole("Y", arguments.words[first + 1], 0, size.height - 1)};
}

GreyWindow parse_window(const Session& session, const Arguments& arguments) {
    GreyWindow window;
    if (!arguments.has("window") || !arguments.has("level")) {
        window = usual_window(session.volumes.volume());
    }
    return {arguments.number("window", window.width), arguments.number("level", window.level)};
}

void write_slice(Session& session, const Arguments& arguments, const Slice& slice,
                 const std::vector<SurfaceContour>& contours, const std::string& title) {
    const GreyWindow window = parse_window(session, arguments);
    const SlicePicture drawn = slice_picture(
        slice, contours, window, session.scene.size,
        fmt::format("{}, window {:.6g} level {:.6g}", title, window.width, window.level));
    PictureExtras extras;
    extras.description = fmt::format("{} of {}", title, session.volumes.volume().name);
    if (session.scene.overlay) {
        extras.marks = drawn.marks;
    }
    session.exports.pictures({&drawn.picture, 1}, arguments.words[2], extras);
}

Frames::Picked picked_at(Session& session, const Pixel& pixel, const std::string& surface) {
    const auto picked = session.frames.pick(pixel.x, pixel.y, surface);
    if (!picked) {
        refuse_command(
            fmt::format("measure: no point of {} lies at pixel ({}, {}); both ends must lie on a "
                        "surface",
                        surface.empty() ? "a surface" : surface, pixel.x, pixel.y));
    }
    return *picked;
}

}  // namespace

Reply run_histogram(Session& session, const Arguments& arguments) {
    const int bins = parse_whole("BINS", arguments.words.empty() ? usual_bins : arguments.words[0]);
    const Volume& volume = session.volumes.volume();
    const Histogram counted = histogram(volume, bins);
    Reply reply{histogram_text(counted), histogram_fields(counted)};
    reply.fields.push_back({"minimum", volume.minimum});
    reply.fields.push_back({"maximum", volume.maximum});
    reply.fields.push_back({"not_finite", static_cast<std::int64_t>(counted.not_finite)});
    return reply;
}

Reply run_slice(Session& session, const Arguments& arguments) {
    const Volume& volume = session.volumes.volume();
    const int axis = arguments.words[0][0] - 'x';
    const int count = axis == 0 ? volume.nx : axis == 1 ? volume.ny : volume.nz;
    const int index = parse_whole("INDEX", arguments.words[1], 0, count - 1);
    const Slice slice = slice_of(volume, axis, index);
    const SliceSide &across = slice.frame.across, &down = slice.frame.down;
    const std::vector<SurfaceContour> contours = contours_of(session.scene, slice);
    const std::string title = fmt::format("slice {} {} of 0..{}", "xyz"[axis], index, count - 1);

    Reply reply;
    reply.text = fmt::format(
        "{}: {} x {} voxels of {:.4g} x {:.4g} mm; {} on the left, {} on the right, {} on top, {} "
        "at the bottom",
        title, across.count, down.count, across.spacing_mm, down.spacing_mm, across.begin,
        across.end, down.begin, down.end);
    if (slice.frame.skew_deg > max_skew_deg) {
        add_warning(reply, fmt::format("its rows and columns are {:.1f} degrees off a right "
                                       "angle, and are shown at one",
                                       slice.frame.skew_deg));
    }
    std::int64_t pieces = 0;
    for (const SurfaceContour& contour : contours) {
        pieces += static_cast<std::int64_t>(contour.pieces.size());
        reply.text += fmt::format("\n{}: {} pieces of contour at {:.6g}", contour.surface->name,
                                  contour.pieces.size(), contour.surface->isovalue);
    }
    reply.fields = {{"size", std::vector<std::int64_t>{across.count, down.count}},
                    {"spacing", std::vector<double>{across.spacing_mm, down.spacing_mm}},
                    {"letters", Fields{{"left", across.begin},
                                       {"right", across.end},
                                       {"top", down.begin},
                                       {"bottom", down.end}}},
                    {"skew_deg", slice.frame.skew_deg},
                    {"contours", pieces}};
    if (arguments.words.size() > 2) {
        write_slice(session, arguments, slice, contours, title);
        reply.text += "\nwrote " + arguments.words[2];
        reply.fields.push_back({"file", arguments.words[2]});
    }
    return reply;
}

Reply run_measure(Session& session, const Arguments& arguments) {
    const Frames::Picked a = picked_at(session, parse_pixel(session, arguments, 0),
                                       shown_surface(session, arguments.text("from", "")));
    const Frames::Picked b = picked_at(session, parse_pixel(session, arguments, 2),
                                       shown_surface(session, arguments.text("to", "")));
    const glm::dvec3 &p = a.pick.p_mm, &q = b.pick.p_mm;
    const double distance_mm = glm::distance(p, q);
    return {fmt::format("{:.2f} mm in a straight line, from {} at ({:.2f}, {:.2f}, {:.2f}) to {} "
                        "at ({:.2f}, {:.2f}, {:.2f}) mm LPS",
                        distance_mm, a.surface, p.x, p.y, p.z, b.surface, q.x, q.y, q.z),
            {{"a_mm", point(p)},
             {"b_mm", point(q)},
             {"distance_mm", distance_mm},
             {"a_surface", a.surface},
             {"b_surface", b.surface}}};
}

Reply run_why(Session& session, const Arguments& arguments) {
    const Pixel pixel = parse_pixel(session, arguments, 0);
    return inspect::LiveFrame::of(session).why(pixel.x, pixel.y);
}

}  // namespace pxpl5::host
