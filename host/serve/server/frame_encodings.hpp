// The newest frame in the forms and encodings that viewers need.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "host/base/shared_words.hpp"
#include "host/serve/encoding/encode.hpp"
#include "host/serve/server/server_mail.hpp"

namespace pxpl5::host::serve {

/// Makes each form and each encoding once, when the first viewer needs it. What it returns is valid
/// until the next frame.
class FrameEncodings {
  public:
    /// Forgets what belongs to another frame. Refinements of a picture share its packed depths.
    void begin(const NewestFrame& frame);

    /// The frame as a viewer gets it: `shown` itself or a copy that differs.
    ///
    /// with_depths  Otherwise all pictures of the frame are one, and the depths are left out.
    /// scale        That the viewer's connection carries, relative to the picture at rest. A frame
    ///              that moves and is larger is made smaller, unless it must keep its size.
    const Shown& form_of(const Shown& shown, bool with_depths, double scale);

    /// The pictures as a JPEG; no quality: as a PNG.
    const std::string& pictures(const Shown& form, const std::optional<JpegQuality>& quality);
    /// Empty if they cannot be packed, with a warning.
    const std::string& depths(const Shown& form);

  private:
    /// Something that was made of words. It keeps them, so that no others come to lie in their
    /// place.
    template <typename Made>
    struct Of {
        SharedWords words;
        Made made;
    };
    using Place = const std::uint32_t*;  ///< Place of the pixels or depths.

    std::uint64_t sequence_ = 0;
    std::map<std::tuple<Place, bool, double>, Of<Shown>> forms_;
    std::map<std::pair<Place, std::optional<JpegQuality>>, Of<std::string>> pictures_;
    std::map<Place, Of<std::string>> depths_;
};

}  // namespace pxpl5::host::serve
