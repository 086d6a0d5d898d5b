// Commands that show slices of the volume.
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/vec3.hpp>
#include <iterator>
#include <optional>
#include <span>

#include "host/base/error.hpp"
#include "host/commands/command_handlers.hpp"
#include "host/commands/text/slice_picture.hpp"
#include "host/commands/text/volume_text.hpp"
#include "host/scene/oblique.hpp"
#include "host/volume/reduced.hpp"

namespace pxpl5::host {

namespace {

/// If the third word names a file, writes the picture to it, and says so.
void write_slice(Reply& reply, Session& session, const Arguments& arguments, const Slice& slice,
                 const std::vector<SurfaceContour>& contours, const std::string& title) {
    if (arguments.words.size() < 3) {
        return;
    }
    const GrayWindow window = window_of(session, arguments);
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
    const Volume& volume = session.volumes.volume();
    if (volume.reduced && !stated_window(volume) &&
        !(arguments.has("window") && arguments.has("level"))) {
        add_warning(reply, fmt::format("the window follows from the values of one voxel in {} "
                                       "along each axis; give window= and level= to set it",
                                       volume.reduction));
    }
    reply.text += fmt::format("\nwindow {:.6g} level {:.6g}\nwrote {}", window.width, window.level,
                              arguments.words[2]);
    const Picture& picture = drawn.picture;
    reply.fields.push_back(
        {"picture_size", std::vector<std::int64_t>{picture.width, picture.height}});
    reply.fields.push_back({"window", window.width});
    reply.fields.push_back({"level", window.level});
    reply.fields.push_back({"file", arguments.words[2]});
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

std::int64_t pieces_of(const std::vector<SurfaceContour>& contours) {
    std::int64_t pieces = 0;
    for (const SurfaceContour& contour : contours) {
        pieces += static_cast<std::int64_t>(contour.pieces.size());
    }
    return pieces;
}

/// "13/30, 360 ms: slice z 30": which volume of a time series the slice is of.
std::string timed(const Volume& volume, const std::string& title) {
    const std::string time = time_place(volume);
    return time.empty() ? title : time + ": " + title;
}

/// The same for programs; nothing without a series.
void add_time(Reply& reply, const Volume& volume) {
    if (volume.frames == 1) {
        return;
    }
    reply.fields.push_back({"frame", std::int64_t{volume.frame}});
    if (const std::optional<double> ms = time_ms(volume, volume.frame)) {
        reply.fields.push_back({"time_ms", *ms});
    }
}

Fields letter_fields(const SliceFrame& frame) {
    return {{"left", frame.across.begin},
            {"right", frame.across.end},
            {"top", frame.down.begin},
            {"bottom", frame.down.end}};
}

std::string letter_text(const SliceFrame& frame) {
    return fmt::format("{} on the left, {} on the right, {} on top, {} at the bottom",
                       frame.across.begin, frame.across.end, frame.down.begin, frame.down.end);
}

Fields slice_fields(const SliceFrame& frame, const std::vector<SurfaceContour>& contours,
                    const std::vector<std::string>& hidden) {
    const SliceSide &across = frame.across, &down = frame.down;
    return {{"size", std::vector<std::int64_t>{across.count, down.count}},
            {"spacing", std::vector<double>{across.spacing_mm, down.spacing_mm}},
            {"letters", letter_fields(frame)},
            {"skew_deg", frame.skew_deg},
            {"reduction", std::int64_t{1}},
            {"contours", pieces_of(contours)},
            {"hidden_in_3d", hidden}};
}

Slice slice_of_values(const ObliquePlane& plane, const std::vector<float>& values) {
    const std::span bytes = std::as_bytes(std::span(values));
    return {oblique_frame(plane), Scalar::float32, {bytes.begin(), bytes.end()}};
}

}  // namespace

GrayWindow window_of(Session& session, const Arguments& arguments) {
    GrayWindow window;
    if (!arguments.has("window") || !arguments.has("level")) {
        window = session.series.window();
    }
    return {arguments.number("window", window.width), arguments.number("level", window.level)};
}

Reply run_slice(Session& session, const Arguments& arguments) {
    const Volume& volume = session.volumes.volume();
    const int axis = arguments.words[0][0] - 'x';
    const int count = axis == 0 ? volume.nx : axis == 1 ? volume.ny : volume.nz;
    const int index = parse_whole("slice: INDEX", arguments.words[1]);
    if (index < 0 || index >= count) {
        refuse_command(fmt::format("slice: {} has no slice {} along {}: give 0 to {}",
                                   volume.source, index, "xyz"[axis], count - 1));
    }
    const std::optional<SlabWish> wish = parse_slab(arguments);
    const Slab slab = wish ? session.voxels.slab(axis, index, *wish)
                           : Slab{session.voxels.slice(axis, index), {}, {index, index}};
    const SliceFrame& frame = slab.middle.frame;
    const std::vector<SurfaceContour> contours = contours_of(session.scene, slab.middle);
    std::string title =
        timed(volume, fmt::format("slice {} {} of 0..{}", "xyz"[axis], index, count - 1));

    Reply reply;
    reply.text = fmt::format("{}: {} x {} voxels of {:.4g} x {:.4g} mm; {}", title,
                             frame.across.count, frame.down.count, frame.across.spacing_mm,
                             frame.down.spacing_mm, letter_text(frame));
    if (frame.skew_deg > max_skew_deg) {
        add_warning(reply, fmt::format("its rows and columns are {:.1f} degrees off a right "
                                       "angle, and are shown at one",
                                       frame.skew_deg));
    }
    const std::vector<std::string> hidden = hidden_in_3d(session.scene, contours);
    reply.text += contour_text(contours, hidden);
    reply.fields = {{"axis", arguments.words[0]},
                    {"index", std::int64_t{index}},
                    {"slices", std::int64_t{count}}};
    std::ranges::move(slice_fields(frame, contours, hidden), std::back_inserter(reply.fields));
    add_time(reply, volume);
    if (wish) {
        const std::string words = slab_words(*wish, slab.range);
        reply.text += fmt::format("\n{}, within {:.6g} mm", words, wish->thickness_mm);
        title += ", " + words;
        reply.fields.push_back({"slab", slab_fields(*wish, slab.range)});
    }
    write_slice(reply, session, arguments, wish ? slab.values : slab.middle, contours, title);
    return reply;
}

Reply run_oblique(Session& session, const Arguments& arguments) {
    const Volume& volume = session.volumes.volume();
    require_all_voxels(volume, "oblique");
    const ObliqueAngles angles{
        parse_number("TILT", arguments.words[0], -max_angle_deg, max_angle_deg) + 0.0,
        parse_number("TURN", arguments.words[1], -max_angle_deg, max_angle_deg) + 0.0};
    const glm::dvec3 through = arguments.has("at") ? parse_triple("at", arguments.text("at", ""),
                                                                  -max_place_mm, max_place_mm)
                                                   : middle_mm(volume);
    const glm::dvec3 spacing = spacing_mm(volume);
    const ObliquePlane plane =
        oblique_plane(volume, angles, through, std::min({spacing.x, spacing.y, spacing.z}));
    const std::vector<float> values = oblique_values(volume, plane);
    if (!meets(plane, volume)) {
        refuse_command(
            fmt::format("oblique: the plane through {} mm does not meet the volume, "
                        "whose middle is at {} mm",
                        place_text(through), place_text(middle_mm(volume))));
    }
    if (std::ranges::all_of(values, [](float value) { return std::isnan(value); })) {
        refuse_command(
            fmt::format("oblique: no pixel of the plane through {} mm has a value: its "
                        "pixels of {:.4g} mm miss the middles of voxels, or the "
                        "voxels there have no value. Choose other angles or another at=",
                        place_text(through), plane.pixel_mm));
    }
    const Slice slice = slice_of_values(plane, values);
    const std::vector<SurfaceContour> contours = contours_of(session.scene, plane, values);
    const std::vector<std::string> hidden = hidden_in_3d(session.scene, contours);
    const std::string title =
        timed(volume, fmt::format("oblique {:.6g} {:.6g} at {} mm", angles.tilt_deg,
                                  angles.turn_deg, place_text(through)));
    Reply reply;
    reply.text = fmt::format("{}: {} x {} pixels of {:.4g} mm; {}", title, plane.width,
                             plane.height, plane.pixel_mm, letter_text(slice.frame)) +
                 contour_text(contours, hidden);
    reply.fields = {{"tilt_deg", angles.tilt_deg},
                    {"turn_deg", angles.turn_deg},
                    {"through_mm", place_numbers(through)},
                    {"center_mm", place_numbers(plane.center_mm)},
                    {"right", place_numbers(plane.right)},
                    {"down", place_numbers(plane.down)},
                    {"size", std::vector<std::int64_t>{plane.width, plane.height}},
                    {"pixel_mm", plane.pixel_mm},
                    {"letters", letter_fields(slice.frame)},
                    {"contours", pieces_of(contours)},
                    {"hidden_in_3d", hidden}};
    add_time(reply, volume);
    write_slice(reply, session, arguments, slice, contours, title);
    return reply;
}

}  // namespace pxpl5::host
