// The settings of the pictures of one command.
#pragma once

#include <string>

#include "host/base/command_descriptor.hpp"
#include "host/session/session.hpp"

namespace pxpl5::host {

/// "1", "4" or "16". Throws RequestError (usage).
int parse_samples(const std::string& command, const std::string& text);

/// Gives the scene the size, samples, overlay and ground of a command's options. The scene has its
/// own again afterwards, also after an error.
class PictureSettings {
  public:
    /// Throws RequestError (usage) for a bad value.
    PictureSettings(Scene& scene, const Arguments& arguments);
    ~PictureSettings();
    PictureSettings(const PictureSettings&) = delete;
    PictureSettings& operator=(const PictureSettings&) = delete;

    /// Whether the ground is to be transparent.
    bool is_transparent() const { return is_transparent_; }

  private:
    Scene& scene_;
    Size size_;
    int samples_;
    bool overlay_;
    StereoMode mode_;
    Color background_;
    bool is_transparent_ = false;
};

/// A picture, and how long drawing took.
struct DrawnPicture {
    Picture picture;
    double draw_ms = 0;
};

/// Draws the scene, if wished without its ground: then twice, over black and over white. The
/// scene's background stays. Throws RequestError as drawing does, and for an anaglyph without
/// ground: each of its colors would need a transparency of its own.
DrawnPicture draw_picture(Session& session, bool is_transparent);

}  // namespace pxpl5::host
