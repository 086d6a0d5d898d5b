// Commands that ask about the volume and the picture, and change nothing.
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <optional>

#include "host/base/error.hpp"
#include "host/commands/command_handlers.hpp"
#include "host/commands/text/picture_text.hpp"
#include "host/commands/text/slice_picture.hpp"
#include "host/commands/text/volume_text.hpp"
#include "host/inspect/why/live_frame.hpp"
#include "host/session/transfer/detail.hpp"

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
    const Size size = composed_size(session.scene.size, session.scene.stereo.mode);
    return {parse_whole("X", arguments.words[first], 0, size.width - 1),
            parse_whole("Y", arguments.words[first + 1], 0, size.height - 1)};
}

GrayWindow parse_window(const Session& session, const Arguments& arguments) {
    GrayWindow window;
    if (!arguments.has("window") || !arguments.has("level")) {
        window = usual_window(session.volumes.volume());
    }
    return {arguments.number("window", window.width), arguments.number("level", window.level)};
}

void write_slice(Session& session, const Arguments& arguments, const Slice& slice,
                 const std::vector<SurfaceContour>& contours, const std::string& title) {
    const GrayWindow window = parse_window(session, arguments);
    const SlicePicture drawn = slice_picture(
        slice, contours, window, session.scene.size,
        {fmt::format("{}, window {:.6g} level {:.6g}", title, window.width, window.level),
         place_warning(session.volumes.volume())});
    PictureExtras extras;
    extras.description = fmt::format("{} of {}", title, session.volumes.volume().name);
    if (session.scene.overlay) {
        extras.marks = drawn.marks;
    }
    session.exports.pictures({&drawn.picture, 1}, arguments.words[2], extras);
}

/// Nothing for a single slice.
std::optional<SlabWish> parse_slab(const Arguments& arguments) {
    const double thickness_mm = arguments.number("slab", 0);
    if (thickness_mm == 0 && arguments.has("kind")) {
        refuse_command(
            fmt::format("slice: kind={} needs a slab, but slab= is {}. Give its thickness in mm, "
                        "for example slab=10",
                        arguments.text("kind", ""), arguments.has("slab") ? "0" : "missing"));
    }
    if (thickness_mm == 0) {
        return std::nullopt;
    }
    const std::string kind = arguments.text("kind", "max");
    const auto at = std::ranges::find(slab_kinds, kind) - slab_kinds.begin();
    return SlabWish{thickness_mm, static_cast<SlabKind>(at)};
}

std::string slab_words(const SlabWish& wish, const SlabRange& range) {
    constexpr std::array words = {"mean", "maximum", "minimum"};
    return fmt::format("{} of slices {} to {}", words.at(static_cast<std::size_t>(wish.kind)),
                       range.first, range.last);
}

Fields slab_fields(const SlabWish& wish, const SlabRange& range) {
    return {{"thickness_mm", wish.thickness_mm},
            {"kind", std::string(slab_kinds.at(static_cast<std::size_t>(wish.kind)))},
            {"slices", std::vector<std::int64_t>{range.first, range.last}}};
}

std::string contour_text(const std::vector<SurfaceContour>& contours,
                         const std::vector<std::string>& hidden) {
    std::string text;
    for (const SurfaceContour& contour : contours) {
        text += fmt::format("\n{}: {} pieces of contour at {:.6g}", contour.surface->name,
                            contour.pieces.size(), contour.surface->isovalue);
    }
    if (!hidden.empty()) {
        text += fmt::format("\nthe 3D picture hides parts that the slice shows: {}",
                            fmt::join(hidden, ", "));
    }
    return text;
}

Fields slice_fields(const SliceFrame& frame, const std::vector<SurfaceContour>& contours,
                    const std::vector<std::string>& hidden) {
    const SliceSide &across = frame.across, &down = frame.down;
    std::int64_t pieces = 0;
    for (const SurfaceContour& contour : contours) {
        pieces += static_cast<std::int64_t>(contour.pieces.size());
    }
    return {{"size", std::vector<std::int64_t>{across.count, down.count}},
            {"spacing", std::vector<double>{across.spacing_mm, down.spacing_mm}},
            {"letters", Fields{{"left", across.begin},
                               {"right", across.end},
                               {"top", down.begin},
                               {"bottom", down.end}}},
            {"skew_deg", frame.skew_deg},
            {"reduction", std::int64_t{1}},
            {"contours", pieces},
            {"hidden_in_3d", hidden}};
}

/// One end of a length.
struct End {
    glm::dvec3 p_mm{0};
    std::string surface;  ///< Empty for a place.

    std::string text() const {
        return fmt::format("{}({:.2f}, {:.2f}, {:.2f})", surface.empty() ? "" : surface + " at ",
                           p_mm.x, p_mm.y, p_mm.z);
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
    return {picked->pick.p_mm, picked->surface};
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

Reply run_slice(Session& session, const Arguments& arguments) {
    const Volume& volume = session.volumes.volume();
    const int axis = arguments.words[0][0] - 'x';
    const int count = axis == 0 ? volume.nx : axis == 1 ? volume.ny : volume.nz;
    const int index = parse_whole("INDEX", arguments.words[1], 0, count - 1);
    const std::optional<SlabWish> wish = parse_slab(arguments);
    const Slab slab = wish ? session.voxels.slab(axis, index, *wish)
                           : Slab{session.voxels.slice(axis, index), {}, {index, index}};
    const SliceFrame& frame = slab.middle.frame;
    const std::vector<SurfaceContour> contours = contours_of(session.scene, slab.middle);
    std::string title = fmt::format("slice {} {} of 0..{}", "xyz"[axis], index, count - 1);

    Reply reply;
    reply.text = fmt::format(
        "{}: {} x {} voxels of {:.4g} x {:.4g} mm; {} on the left, {} on the right, {} on top, {} "
        "at the bottom",
        title, frame.across.count, frame.down.count, frame.across.spacing_mm, frame.down.spacing_mm,
        frame.across.begin, frame.across.end, frame.down.begin, frame.down.end);
    if (frame.skew_deg > max_skew_deg) {
        add_warning(reply, fmt::format("its rows and columns are {:.1f} degrees off a right "
                                       "angle, and are shown at one",
                                       frame.skew_deg));
    }
    const std::vector<std::string> hidden = hidden_in_3d(session.scene, contours);
    reply.text += contour_text(contours, hidden);
    reply.fields = slice_fields(frame, contours, hidden);
    if (wish) {
        const std::string words = slab_words(*wish, slab.range);
        reply.text += fmt::format("\n{}, within {:.6g} mm", words, wish->thickness_mm);
        title += ", " + words;
        reply.fields.push_back({"slab", slab_fields(*wish, slab.range)});
    }
    if (arguments.words.size() > 2) {
        write_slice(session, arguments, wish ? slab.values : slab.middle, contours, title);
        if (volume.reduced && !stated_window(volume) &&
            !(arguments.has("window") && arguments.has("level"))) {
            add_warning(reply, fmt::format("the window follows from the values of one voxel in {} "
                                           "along each axis; give window= and level= to set it",
                                           volume.reduction));
        }
        reply.text += "\nwrote " + arguments.words[2];
        reply.fields.push_back({"file", arguments.words[2]});
    }
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
            {{"a_mm", point(a.p_mm)},
             {"b_mm", point(b.p_mm)},
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
