#include "host/commands/pictures/picture_settings.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "host/base/command_line.hpp"
#include "host/base/error.hpp"
#include "host/scene/ground.hpp"
#include "host/scene/sample_offsets.hpp"

namespace pxpl5::host {

namespace {

/// Gives the scene its background again.
class KeptBackground {
  public:
    explicit KeptBackground(Scene& scene) : scene_(scene), background_(scene.background) {}
    ~KeptBackground() { scene_.background = background_; }
    KeptBackground(const KeptBackground&) = delete;
    KeptBackground& operator=(const KeptBackground&) = delete;

  private:
    Scene& scene_;
    Color background_;
};

}  // namespace

int parse_samples(const std::string& command, const std::string& text) {
    const int samples = parse_whole("samples", text, 1, sample_counts.back());
    if (std::ranges::find(sample_counts, samples) == sample_counts.end()) {
        refuse_command(fmt::format("{}: {} samples per pixel, must be {}", command, samples,
                                   fmt::join(sample_counts, ", ")));
    }
    return samples;
}

PictureSettings::PictureSettings(Scene& scene, const Arguments& arguments)
    : scene_(scene),
      size_(scene.size),
      samples_(scene.samples),
      overlay_(scene.overlay),
      mode_(scene.stereo.mode),
      background_(scene.background) {
    const Size size = arguments.has("size")
                          ? parse_size(arguments.text("size", ""), 1, max_user_picture_px)
                          : size_;
    const int samples =
        parse_samples(arguments.name, arguments.text("samples", std::to_string(samples_)));
    const std::string ground = arguments.text("ground", "shown");
    is_transparent_ = ground == "transparent";
    const Color background =
        ground == "shown" || is_transparent_ ? background_ : parse_color(ground);
    scene.size = size;
    scene.samples = samples;
    scene.overlay = arguments.text("overlay", overlay_ ? "on" : "off") == "on";
    scene.background = background;
}

PictureSettings::~PictureSettings() {
    scene_.size = size_;
    scene_.samples = samples_;
    scene_.overlay = overlay_;
    scene_.stereo.mode = mode_;
    scene_.background = background_;
}

DrawnPicture draw_picture(Session& session, bool is_transparent) {
    const auto draw = [&session] {
        Picture picture = session.frames.draw();
        return DrawnPicture{std::move(picture), session.frames.last().elapsed_ms};
    };
    if (!is_transparent) {
        return draw();
    }
    Scene& scene = session.scene;
    if (scene.stereo.mode == StereoMode::anaglyph) {
        throw RequestError(ExitCode::usage,
                           "a transparent ground is not possible in an anaglyph, which mixes the "
                           "pictures of both eyes in one pixel. Type `stereo sbs` or `stereo off` "
                           "first, or name a color: ground=white");
    }
    const KeptBackground kept(scene);
    scene.background = {0, 0, 0};
    DrawnPicture drawn = draw();
    scene.background = {255, 255, 255};
    const DrawnPicture over_white = draw();
    const auto pixels = [](const Picture& picture) {
        return std::span(picture.rgba.data(), picture.rgba.size());
    };
    drawn.picture.rgba =
        without_ground(pixels(drawn.picture), pixels(over_white.picture), scene.samples);
    drawn.draw_ms += over_white.draw_ms;
    return drawn;
}

}  // namespace pxpl5::host
