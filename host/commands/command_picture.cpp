// Commands that write pictures.
#include <fmt/core.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>
#include <vector>

#include "host/base/error.hpp"
#include "host/commands/command_handlers.hpp"
#include "host/commands/command_options.hpp"
#include "host/commands/text/picture_text.hpp"
#include "host/session/transfer/detail.hpp"

namespace pxpl5::host {

namespace {

constexpr int max_animation_frames = 2'000;

/// Whether all pixels are the background.
bool is_blank(const Picture& picture) {
    return std::ranges::count(picture.rgba, picture.rgba[0]) == std::ssize(picture.rgba);
}

/// Where the pictures of a command go that draws many: nowhere, into a file each, or into one
/// animation.
class PictureFiles {
  public:
    /// Refuses the command if its `at`-th word, which may be missing, names no such place.
    PictureFiles(Session& session, const Arguments& arguments, std::size_t at, int count)
        : session_(session), delay_ms_(arguments.number("delay_ms", 40)) {
        if (arguments.words.size() > at) {
            pattern_ = arguments.words[at];
        }
        is_animation_ = pattern_.ends_with(".gif");
        if (!pattern_.empty() && !is_animation_ && pattern_.find("{}") == std::string::npos) {
            refuse_command(
                fmt::format("{}: '{}' is no .gif and has no {{}} where the frame's number goes",
                            arguments.name, pattern_));
        }
        if (is_animation_ && count > max_animation_frames) {
            refuse_command(fmt::format("{}: {} frames are too many for {}, {} are the most",
                                       arguments.name, count, pattern_, max_animation_frames));
        }
    }

    void take(int index, const Picture& picture, const Camera& camera) {
        is_blank_ = is_blank_ && !pattern_.empty() && is_blank(picture);
        if (is_animation_) {
            pictures_.push_back(picture);
        } else if (!pattern_.empty()) {
            std::string path = pattern_;
            path.replace(path.find("{}"), 2, fmt::format("{:04}", index));
            session_.exports.pictures({&picture, 1}, path, picture_extras(session_, camera));
            ++written_;
        }
    }
    /// Writes the animation, if it is one.
    void finish() {
        if (is_animation_) {
            PictureExtras extras = animation_extras(session_);
            extras.delay_ms = static_cast<int>(delay_ms_);
            session_.exports.pictures(pictures_, pattern_, extras);
            written_ = 1;
        }
    }
    std::int64_t written() const { return written_; }
    /// Adds a warning if pictures were written in which nothing is visible.
    void warn(Reply& reply) const {
        if (is_blank_ && written_ != 0) {
            add_warning(reply, "nothing is visible in any of the pictures", "; ");
        }
    }
    /// Whether files were written between the pictures: times then tell of writing.
    bool has_interrupted() const { return written_ != 0 && !is_animation_; }
    /// For the end of the command's answer.
    std::string text() const {
        return has_interrupted() ? fmt::format(", {} pictures written", written_)
               : written_ != 0   ? "; wrote " + pattern_
                                 : "";
    }

  private:
    Session& session_;
    double delay_ms_;
    std::string pattern_;
    bool is_animation_ = false, is_blank_ = true;
    std::int64_t written_ = 0;
    std::vector<Picture> pictures_;
};

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

/// The settings of one picture. The scene has its own again afterwards.
class OnePicture {
  public:
    OnePicture(Scene& scene, const Arguments& arguments)
        : scene_(scene),
          size_(scene.size),
          samples_(scene.samples),
          overlay_(scene.overlay),
          mode_(scene.stereo.mode) {
        const std::string& path = arguments.words[0];
        check_eyes(arguments.name, path, mode_ != StereoMode::off);
        const bool is_pair = is_pair_in_one(path) || is_pair_in_two(path);
        const Size size = arguments.has("size")
                              ? parse_size(arguments.text("size", ""), 1, max_user_picture_px)
                              : size_;
        const std::string samples = arguments.text("samples", std::to_string(samples_));
        scene.samples = parse_samples(arguments.name, samples);
        scene.size = size;
        scene.overlay = arguments.text("overlay", overlay_ ? "on" : "off") == "on";
        if (is_pair) {  // The left eye's picture lies at the right in a .jps file.
            scene.stereo.mode =
                is_pair_in_one(path) ? StereoMode::crossed : StereoMode::side_by_side;
        }
    }
    ~OnePicture() {
        scene_.size = size_;
        scene_.samples = samples_;
        scene_.overlay = overlay_;
        scene_.stereo.mode = mode_;
    }
    OnePicture(const OnePicture&) = delete;
    OnePicture& operator=(const OnePicture&) = delete;

  private:
    Scene& scene_;
    Size size_;
    int samples_;
    bool overlay_;
    StereoMode mode_;
};

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
    const OnePicture settings(session.scene, arguments);
    const Picture picture = session.frames.draw();
    const double draw_ms = session.frames.last().elapsed_ms;
    const std::string& path = arguments.words[0];
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
    PictureFiles files(session, arguments, 1, count);
    const OrbitReport report = session.frames.orbit(
        count,
        [&](int index, const Picture& picture, const Camera& camera) {
            files.take(index, picture, camera);
        },
        in_flight);
    files.finish();
    const double rate = report.frames * 1000.0 / report.elapsed_ms;
    Reply reply{fmt::format("{} frames in {:.0f} ms", report.frames, report.elapsed_ms),
                {{"frames", std::int64_t{report.frames}},
                 {"elapsed_ms", report.elapsed_ms},
                 {"inflight", std::int64_t{in_flight}},
                 {"latency_ms", to_fields(report.latency_ms)},
                 {"written", files.written()}}};
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
    PictureFiles files(session, arguments, 4, count);
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
