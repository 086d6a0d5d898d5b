// Commands that write pictures.
#include <fmt/core.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/part_file.hpp"
#include "host/commands/command_handlers.hpp"
#include "host/commands/command_options.hpp"
#include "host/commands/pictures/picture_files.hpp"
#include "host/commands/pictures/picture_settings.hpp"
#include "host/commands/text/picture_text.hpp"
#include "host/session/transfer/detail.hpp"

namespace pxpl5::host {

namespace {

/// States that the newest picture is simplified, if it is.
void add_simplified(Reply& reply, const Session& session) {
    const double moved_mm = session.frames.last().moved_mm;
    reply.fields.push_back({"moved_mm", moved_mm});
    if (moved_mm > 0) {
        reply.text += fmt::format(
            "; simplified: no point is farther than {} mm from the exact "
            "surface, and small parts may be missing",
            bound_text(moved_mm));
    }
}

Fields to_fields(const Spread& spread) {
    return {{"median", spread.median}, {"p95", spread.p95}, {"max", spread.max}};
}

/// Throws RequestError (usage) for a transparent ground, which only single pictures have.
void refuse_transparent(const Arguments& arguments, const PictureSettings& settings) {
    if (settings.is_transparent()) {
        refuse_command(fmt::format(
            "{}: its pictures cannot have a transparent ground. Name a color: ground=white",
            arguments.name));
    }
}

/// Throws RequestError (usage) if the file cannot have a transparent ground.
void check_transparent(const std::string& path) {
    const std::string suffix = suffix_of(path);
    if (suffix != ".png" && suffix != ".tif" && suffix != ".tiff") {
        refuse_command(fmt::format(
            "snapshot: {} cannot have a transparent ground. Write a .png or .tif, or name a "
            "color: ground=white",
            path));
    }
}

/// Both halves of a picture, left half first.
std::vector<Picture> halves_of(const Picture& pair) {
    const std::ptrdiff_t width = pair.width / 2;
    std::vector<Picture> halves;
    for (const int side : {0, 1}) {
        std::vector<std::uint32_t> half;
        for (int y = 0; y < pair.height; ++y) {
            const auto row = pair.rgba.begin() + std::ptrdiff_t{y} * pair.width + side * width;
            half.insert(half.end(), row, row + width);
        }
        halves.push_back({pair.width / 2, pair.height, std::move(half)});
    }
    return halves;
}

}  // namespace

Reply run_snapshot(Session& session, const Arguments& arguments) {
    const std::string& path = arguments.words[0];
    check_eyes(arguments.name, path, session.scene.stereo.mode != StereoMode::off);
    const PictureSettings settings(session.scene, arguments);
    if (settings.is_transparent()) {
        check_transparent(path);
    }
    if (is_pair_in_one(path)) {  // The left eye's picture lies at the right in a .jps file.
        session.scene.stereo.mode = StereoMode::crossed;
    } else if (is_pair_in_two(path)) {
        session.scene.stereo.mode = StereoMode::side_by_side;
    }
    const auto [picture, draw_ms] = draw_picture(session, settings.is_transparent());
    const bool is_two = is_pair_in_two(path);
    const std::vector<Picture> pictures = is_two ? halves_of(picture) : std::vector{picture};
    session.exports.pictures(pictures, path,
                             picture_extras(session, session.scene.camera,
                                            is_two ? EyesInFile::apart : EyesInFile::composed));
    const int width = pictures[0].width, height = pictures[0].height;
    Reply reply{fmt::format("wrote {} ({}{}x{}, drawn in {:.1f} ms)", path,
                            is_two ? "2 pictures of " : "", width, height, draw_ms),
                {{"file", path},
                 {"width", std::int64_t{width}},
                 {"height", std::int64_t{height}},
                 {"pictures", std::int64_t{std::ssize(pictures)}},
                 {"draw_ms", draw_ms}}};
    add_simplified(reply, session);
    if (is_blank(picture)) {
        add_warning(reply, "nothing is visible in it", "; ");
    }
    return reply;
}

Reply run_orbit(Session& session, const Arguments& arguments) {
    const int count = parse_whole("N", arguments.words[0]);
    const int in_flight = parse_whole("inflight", arguments.text("inflight", "2"));
    const double degrees = arguments.number("degrees", 360);
    const PictureSettings settings(session.scene, arguments);
    refuse_transparent(arguments, settings);
    PictureFiles files(session, arguments, 1, count);
    const OrbitReport report = session.frames.orbit(
        count,
        [&](int index, const Picture& picture, const Camera& camera) {
            files.take(index, picture, camera);
        },
        in_flight, degrees);
    files.finish();
    const double rate = report.frames * 1000.0 / report.elapsed_ms;
    Reply reply{fmt::format("{} frames in {:.0f} ms", report.frames, report.elapsed_ms),
                {{"frames", std::int64_t{report.frames}},
                 {"elapsed_ms", report.elapsed_ms},
                 {"inflight", std::int64_t{in_flight}},
                 {"latency_ms", to_fields(report.latency_ms)},
                 {"written", files.written()}}};
    files.add_files(reply);
    if (!files.has_interrupted()) {
        reply.text +=
            fmt::format(", {:.1f} frames/s, a view's picture after {:.1f} ms (p95 {:.1f})", rate,
                        report.latency_ms.median, report.latency_ms.p95);
        reply.fields.push_back({"frames_per_s", rate});
    }
    add_simplified(reply, session);
    reply.text += files.text();
    files.warn(reply);
    return reply;
}

Reply run_sweep(Session& session, const Arguments& arguments) {
    const std::string& name = arguments.words[0];
    const double first = parse_number("FROM", arguments.words[1]);
    const double last = parse_number("TO", arguments.words[2]);
    const int count = parse_whole("N", arguments.words[3]);
    const PictureSettings settings(session.scene, arguments);
    refuse_transparent(arguments, settings);
    PictureFiles files(session, arguments, 4, count);
    files.set_swept({name, first, last});
    if (const std::optional<Surface> known = session.surfaces.find(name)) {
        session.surfaces.end_comparison(known->compared_with.empty() ? name : known->compared_with);
    }
    std::vector<double> isovalues;
    for (int i = 0; i < count; ++i) {
        isovalues.push_back(first + (last - first) * i / (count - 1));
    }
    std::int64_t empty = 0;
    const SweepReport report = session.surfaces.sweep(
        name, isovalues, [&](int index, const Picture& picture, const SurfaceReport& built) {
            empty += built.triangles == 0 ? 1 : 0;
            files.take(index, picture, session.scene.camera);
        });
    files.finish();
    Reply reply{
        fmt::format("{} isovalues {} .. {}: extracted in {:.1f} ms (p95 {:.1f}), picture after "
                    "{:.1f} ms (p95 {:.1f}){}",
                    report.changes, first, last, report.extraction_ms.median,
                    report.extraction_ms.p95, report.picture_ms.median, report.picture_ms.p95,
                    files.text()),
        {{"changes", std::int64_t{report.changes}},
         {"extraction_ms", to_fields(report.extraction_ms)},
         {"picture_ms", to_fields(report.picture_ms)},
         {"empty", empty},
         {"written", files.written()}}};
    files.add_files(reply);
    if (empty != 0) {
        add_warning(
            reply,
            fmt::format("{} of them have no surface: the volume's values are {} .. {}", empty,
                        session.volumes.volume().minimum, session.volumes.volume().maximum));
    }
    files.warn(reply);
    return reply;
}

}  // namespace pxpl5::host
